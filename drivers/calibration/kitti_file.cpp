#include "drivers/calibration/kitti_file.h"

#include <Eigen/Dense>

#include "drivers/calibration/text.h"

namespace pavo {
namespace {

constexpr double kRoundingOfRotations = 1e-3;

std::string_view key_of(std::string_view line) {
  const std::size_t colon = line.find(':');
  return colon == std::string_view::npos ? std::string_view{} : trim(line.substr(0, colon));
}

bool is_camera_key(std::string_view key) {
  const auto ends_with_camera = [&] { return key.back() >= '0' && key.back() <= '3'; };
  if (key.size() == 2 && key[0] == 'P') return ends_with_camera();
  for (const std::string_view prefix : {"P_rect_0", "S_rect_0", "K_0", "D_0"}) {
    if (key.size() == prefix.size() + 1 && key.starts_with(prefix)) return ends_with_camera();
  }
  return false;
}

}  // namespace

bool KittiFile::recognises(std::string_view text) {
  for (const TextLine& line : significant_lines(text)) {
    if (is_camera_key(key_of(line.text))) return true;
  }
  return false;
}

KittiFile::KittiFile(std::string_view text, std::string name) : name_(std::move(name)) {
  for (const TextLine& line : significant_lines(text)) {
    const std::string key(key_of(line.text));
    if (key.empty()) fail_at(name_, line.number, "expected 'key: numbers', found " + quoted(line.text));
    const std::string values(trim(line.text.substr(line.text.find(':') + 1)));
    if (!entries_.try_emplace(key, Entry{line.number, values}).second) {
      fail_at(name_, line.number, quoted(key) + " comes a second time: keep one of the two");
    }
  }
}

int KittiFile::line(const std::string& key) const {
  const auto entry = entries_.find(key);
  return entry == entries_.end() ? 0 : entry->second.line;
}

std::vector<double> KittiFile::numbers(const std::string& key, std::size_t count) const {
  const std::string expected = "expected '" + key + ": " + std::to_string(count) + " finite numbers'";
  const auto entry = entries_.find(key);
  if (entry == entries_.end()) fail_at(name_, 0, "has no " + key + ": " + expected);
  const auto complain = [&](const std::string& what) {
    fail_at(name_, entry->second.line, key + what + ": " + expected);
  };
  const auto fields = split_fields(entry->second.values);
  if (fields.size() != count) complain(" has " + std::to_string(fields.size()) + " values");
  std::vector<double> values;
  for (const std::string_view field : fields) {
    if (const auto value = parse_number(field)) {
      values.push_back(*value);
    } else {
      complain(" has " + quoted(field));
    }
  }
  return values;
}

Eigen::Matrix3d KittiFile::rotation(const std::string& key) const {
  const auto values = numbers(key, 9);
  return nearest_rotation(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data()), name_,
                          line(key), key);
}

SE3 KittiFile::motion(const std::string& rotation_key, const std::string& translation_key) const {
  const auto t = numbers(translation_key, 3);
  return {rotation(rotation_key), {t[0], t[1], t[2]}};
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& m, const std::string& file, int line, const std::string& what) {
  // Entries beyond 2 are far from any rotation, and keep the SVD away from overflow.
  if (m.cwiseAbs().maxCoeff() < 2) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d R = svd.matrixU() * svd.matrixV().transpose();
    if (R.determinant() > 0 && (R - m).norm() < kRoundingOfRotations) return R;
  }
  fail_at(file, line, what + " is not a rotation: expected an orthonormal 3x3 matrix with determinant 1");
}

}  // namespace pavo
