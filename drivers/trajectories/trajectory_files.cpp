#include "drivers/trajectories/trajectory_files.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <span>
#include <stdexcept>

namespace pavo {
namespace {

constexpr long double kLatest_s = 4e9L;  // differences of nanoseconds stay within 64 bits
constexpr std::string_view kBlanks = " \t\r\v\f";

/// Walks over the lines of a text, and knows where it is for messages.
class Lines {
 public:
  Lines(std::string_view text, const std::string& name) : rest_(text), name_(name) {}

  bool next() {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find('\n');
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    ++number_;
    return true;
  }
  bool blank() const { return line_.find_first_not_of(kBlanks) == std::string_view::npos; }
  bool comment() const { return !blank() && line_[line_.find_first_not_of(kBlanks)] == '#'; }
  std::string_view line() const { return line_; }
  std::size_t number() const { return number_; }

  [[noreturn]] void fail(const std::string& message, std::size_t number = 0) const {
    throw std::runtime_error(name_ + ":" + std::to_string(number ? number : number_) + ": " + message);
  }

 private:
  std::string_view rest_;
  std::string_view line_;
  const std::string& name_;
  std::size_t number_ = 0;
};

/// A piece of a file for a one-line message: short, and without the bytes that would garble a terminal.
std::string quoted(std::string_view token) {
  std::string text = "'";
  for (const char c : token.substr(0, 24)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (token.size() > 24 ? "...'" : "'");
}

std::string_view take_token(std::string_view& rest) {
  const std::size_t begin = std::min(rest.find_first_not_of(kBlanks), rest.size());
  const std::size_t end = std::min(rest.find_first_of(kBlanks, begin), rest.size());
  const std::string_view token = rest.substr(begin, end - begin);
  rest.remove_prefix(end);
  return token;
}

std::size_t count_tokens(std::string_view line) {
  std::size_t count = 0;
  while (!take_token(line).empty()) ++count;
  return count;
}

/// std::from_chars knows no locale, and no leading '+'.
template <typename Real>
Real number(const Lines& lines, std::string_view token) {
  std::string_view digits = token;
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
  Real value = 0;
  // A copy: libstdc++ 12 takes strlen() of what begins like "nan", so a zero must follow (the fuzzer read beyond a
  // file).
  const std::string terminated(digits);
  digits = terminated;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error == std::errc::result_out_of_range) lines.fail(quoted(token) + " is beyond the numbers a double can hold");
  if (error != std::errc{} || end != digits.data() + digits.size())
    lines.fail("expected a number, found " + quoted(token));
  if (!std::isfinite(value)) lines.fail("expected a finite number, found " + quoted(token));
  return value;
}

/// Seconds as nanoseconds. A long double holds 19 digits, so that today's date keeps its nanoseconds.
std::int64_t time_ns(const Lines& lines, std::string_view token) {
  const long double seconds = number<long double>(lines, token);
  if (std::abs(seconds) > kLatest_s) lines.fail("the time " + quoted(token) + " is out of range: expected seconds");
  return std::llround(seconds * 1e9L);
}

void check_order(const Lines& lines, const std::vector<std::int64_t>& times_ns, std::int64_t t_ns,
                 std::string_view token) {
  if (!times_ns.empty() && t_ns <= times_ns.back())
    lines.fail("the time " + quoted(token) + " does not come after the one before it: expected increasing times");
}

std::string_view first_token(std::string_view line) {
  return take_token(line);
}

void check_count(const Lines& lines, std::size_t expected, const char* what) {
  const std::size_t found = count_tokens(lines.line());
  if (found != expected)
    lines.fail("expected " + std::to_string(expected) + " numbers (" + what + "), found " + std::to_string(found));
}

Eigen::Vector3d position(const Lines& lines, double x, double y, double z) {
  if (std::max({std::abs(x), std::abs(y), std::abs(z)}) > kFarthest_m)
    lines.fail("the position is more than 1e9 m from the origin: expected metres");
  return {x, y, z};
}

Eigen::Matrix3d rotation(const Lines& lines, const Eigen::Matrix3d& R) {
  const double off = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(off <= kRotationTolerance) || R.determinant() < 0)
    lines.fail("the left 3x3 part is no rotation: expected the rows of [R | t], camera to world");
  if (off <= kRotationRounding) return R;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

SE3 kitti_pose(const Lines& lines) {
  check_count(lines, 12, "a row-major 3x4 pose matrix");
  std::array<double, 12> m{};
  std::string_view rest = lines.line();
  for (double& value : m) value = number<double>(lines, take_token(rest));
  SE3 pose;
  pose.t = position(lines, m[3], m[7], m[11]);
  Eigen::Matrix3d R;
  R << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
  pose.R = rotation(lines, R);
  return pose;
}

SE3 tum_pose(const Lines& lines, std::string_view rest) {
  std::array<double, 7> m{};
  for (double& value : m) value = number<double>(lines, take_token(rest));
  const Eigen::Quaterniond q(m[6], m[3], m[4], m[5]);
  if (!(std::abs(q.norm() - 1) <= kQuaternionTolerance))
    lines.fail("qx qy qz qw is no unit quaternion: its norm is " + std::to_string(q.norm()));
  return {q.normalized().toRotationMatrix(), position(lines, m[0], m[1], m[2])};
}

/// "%.9e", but with a point in every locale.
void append_number(std::string& line, double value) {
  std::array<char, 32> digits{};
  const auto end =
      std::to_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::scientific, 9).ptr;
  line.append(digits.data(), end);
}

}  // namespace

Trajectory parse_kitti_poses(std::string_view text, const std::string& name) {
  Trajectory trajectory;
  Lines lines(text, name);
  std::optional<std::size_t> blank;
  while (lines.next()) {
    if (lines.blank()) {
      blank = blank.value_or(lines.number());
      continue;
    }
    if (blank) lines.fail("a blank line between poses: expected one pose per frame", *blank);
    trajectory.T_w_c.push_back(kitti_pose(lines));
  }
  if (trajectory.T_w_c.empty()) throw std::runtime_error(name + ": no pose in it: expected 12 numbers a line (KITTI)");
  return trajectory;
}

Trajectory parse_tum(std::string_view text, const std::string& name) {
  Trajectory trajectory;
  Lines lines(text, name);
  while (lines.next()) {
    if (lines.blank() || lines.comment()) continue;
    check_count(lines, 8, "timestamp tx ty tz qx qy qz qw");
    std::string_view rest = lines.line();
    const std::string_view stamp = take_token(rest);
    const std::int64_t t_ns = time_ns(lines, stamp);
    check_order(lines, trajectory.t_ns, t_ns, stamp);
    trajectory.T_w_c.push_back(tum_pose(lines, rest));
    trajectory.t_ns.push_back(t_ns);
  }
  if (trajectory.T_w_c.empty()) throw std::runtime_error(name + ": no pose in it: expected 8 numbers a line (TUM)");
  return trajectory;
}

Trajectory parse_trajectory(std::string_view text, const std::string& name) {
  Lines lines(text, name);
  while (lines.next()) {
    if (lines.blank() || lines.comment()) continue;
    const std::size_t count = count_tokens(lines.line());
    if (count == 12) return parse_kitti_poses(text, name);
    if (count == 8) return parse_tum(text, name);
    lines.fail("expected 12 numbers (KITTI) or 8 (TUM) a line, found " + std::to_string(count));
  }
  throw std::runtime_error(name + ": no pose in it: expected 12 numbers (KITTI) or 8 (TUM) a line");
}

std::vector<std::int64_t> parse_times(std::string_view text, const std::string& name) {
  std::vector<std::int64_t> times_ns;
  Lines lines(text, name);
  std::optional<std::size_t> blank;
  while (lines.next()) {
    if (lines.blank()) {
      blank = blank.value_or(lines.number());
      continue;
    }
    if (blank) lines.fail("a blank line between times: expected one time per frame", *blank);
    check_count(lines, 1, "seconds");
    const std::string_view token = first_token(lines.line());
    const std::int64_t t_ns = time_ns(lines, token);
    check_order(lines, times_ns, t_ns, token);
    times_ns.push_back(t_ns);
  }
  if (times_ns.empty()) throw std::runtime_error(name + ": no time in it: expected seconds, one number a line");
  return times_ns;
}

Trajectory read_kitti_poses(const std::string& path) {
  return parse_kitti_poses(read_whole_file(path), path);
}
Trajectory read_tum(const std::string& path) {
  return parse_tum(read_whole_file(path), path);
}
Trajectory read_trajectory(const std::string& path) {
  return parse_trajectory(read_whole_file(path), path);
}
std::vector<std::int64_t> read_times(const std::string& path) {
  return parse_times(read_whole_file(path), path);
}

void append_kitti_line(std::string& line, const SE3& T_w_c) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      append_number(line, column < 3 ? T_w_c.R(row, column) : T_w_c.t(row));
      line += row == 2 && column == 3 ? '\n' : ' ';
    }
  }
}

void append_tum_line(std::string& line, std::int64_t t_ns, const SE3& T_w_c) {
  constexpr std::uint64_t kSecond = 1'000'000'000;
  const std::uint64_t magnitude = t_ns < 0 ? 0 - static_cast<std::uint64_t>(t_ns) : static_cast<std::uint64_t>(t_ns);
  if (t_ns < 0) line += '-';
  std::array<char, 32> digits{};
  line.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), magnitude / kSecond).ptr);
  line += '.';
  // A leading 1 keeps the fraction's zeros.
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), kSecond + magnitude % kSecond).ptr;
  line.append(digits.data() + 1, end);
  Eigen::Quaterniond q = Eigen::Quaterniond(T_w_c.R).normalized();
  if (q.w() < 0) q.coeffs() *= -1;
  for (const double value : {T_w_c.t.x(), T_w_c.t.y(), T_w_c.t.z(), q.x(), q.y(), q.z(), q.w()}) {
    line += ' ';
    append_number(line, value);
  }
  line += '\n';
}

void KittiWriter::write(const SE3& T_w_c) {
  line_.clear();
  append_kitti_line(line_, T_w_c);
  file_.append(line_);
}

void TumWriter::write(std::int64_t t_ns, const SE3& T_w_c) {
  line_.clear();
  append_tum_line(line_, t_ns, T_w_c);
  file_.append(line_);
}

void write_kitti_poses(const std::string& path, const Trajectory& trajectory) {
  std::string text;
  for (const SE3& T_w_c : trajectory.T_w_c) append_kitti_line(text, T_w_c);
  write_whole_file(path, text);
}

void write_tum(const std::string& path, const Trajectory& trajectory) {
  if (trajectory.t_ns.size() != trajectory.T_w_c.size())
    throw std::invalid_argument(path + ": TUM's format needs one time per pose");
  std::string text;
  for (std::size_t i = 0; i < trajectory.T_w_c.size(); ++i)
    append_tum_line(text, trajectory.t_ns[i], trajectory.T_w_c[i]);
  write_whole_file(path, text);
}

}  // namespace pavo
