#include "stages/evaluation/errors.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

namespace pavo {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

SE3 scaled(const SE3& pose, double scale) {
  return {pose.R, scale * pose.t};
}

/// The motion from pose i to pose j, as camera j sees it from camera i.
SE3 motion(const std::vector<SE3>& T_w_c, std::size_t i, std::size_t j) {
  return T_w_c[i].inverse() * T_w_c[j];
}

void add_squares(ParameterRmse& sum, const SE3& estimate, const SE3& truth) {
  sum.leftCols<3>() += (estimate.R - truth.R).cwiseAbs2();
  sum.rightCols<1>() += (estimate.t - truth.t).cwiseAbs2();
}

/// The way along the path up to each pose.
std::vector<double> distances_m(const std::vector<SE3>& T_w_c) {
  std::vector<double> distances{0};
  for (std::size_t i = 1; i < T_w_c.size(); ++i)
    distances.push_back(distances.back() + (T_w_c[i].t - T_w_c[i - 1].t).norm());
  return distances;
}

struct Sum {
  double t = 0, r = 0;
  std::size_t segments = 0;

  void operator+=(const Sum& other) {
    t += other.t;
    r += other.r;
    segments += other.segments;
  }
  std::optional<SegmentErrors> mean() const {
    if (segments == 0) return std::nullopt;
    const double n = static_cast<double>(segments);
    return SegmentErrors{100 * t / n, 100 * kDegrees * r / n, segments};
  }
};

}  // namespace

Statistics statistics(std::vector<double> values) {
  if (values.empty()) throw std::invalid_argument("statistics of no values");
  const double n = static_cast<double>(values.size());
  Statistics result;
  for (const double value : values) {
    result.rmse += value * value;
    result.mean += value;
  }
  result.rmse = std::sqrt(result.rmse / n);
  result.mean /= n;
  std::sort(values.begin(), values.end());
  result.median = std::midpoint(values[(values.size() - 1) / 2], values[values.size() / 2]);
  result.max = values.back();
  return result;
}

double rotation_angle_rad(const Eigen::Matrix3d& R) {
  const Eigen::Vector3d twice_sine(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  return std::atan2(twice_sine.norm(), R.trace() - 1);
}

Statistics absolute_errors_m(const PosePairs& pairs, const Similarity& S) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < pairs.truth.size(); ++i)
    errors.push_back((S * pairs.estimate[i].t - pairs.truth[i].t).norm());
  return statistics(std::move(errors));
}

ParameterRmse pose_rmse(const PosePairs& pairs, double scale) {
  ParameterRmse sum = ParameterRmse::Zero();
  for (std::size_t i = 0; i < pairs.truth.size(); ++i)
    add_squares(sum, scaled(motion(pairs.estimate, 0, i), scale), motion(pairs.truth, 0, i));
  return (sum / static_cast<double>(pairs.truth.size())).cwiseSqrt();
}

ParameterRmse motion_rmse(const PosePairs& pairs, double scale) {
  ParameterRmse sum = ParameterRmse::Zero();
  for (std::size_t i = 1; i < pairs.truth.size(); ++i)
    add_squares(sum, scaled(motion(pairs.estimate, i - 1, i), scale), motion(pairs.truth, i - 1, i));
  return (sum / static_cast<double>(pairs.truth.size() - 1)).cwiseSqrt();
}

MotionErrors motion_errors(const PosePairs& pairs, double scale) {
  std::vector<double> translations_m, rotations_deg;
  for (std::size_t i = 1; i < pairs.truth.size(); ++i) {
    const SE3 error = motion(pairs.truth, i - 1, i).inverse() * scaled(motion(pairs.estimate, i - 1, i), scale);
    translations_m.push_back(error.t.norm());
    rotations_deg.push_back(kDegrees * rotation_angle_rad(error.R));
  }
  return {statistics(std::move(translations_m)), statistics(std::move(rotations_deg))};
}

SegmentErrorsByLength segment_errors(const PosePairs& pairs, double scale, std::span<const double> lengths_m,
                                     int step) {
  if (step < 1) throw std::invalid_argument("segments start at every step-th frame: step must be 1 or more");
  const std::vector<double> distances = distances_m(pairs.truth);
  SegmentErrorsByLength result;
  Sum all;
  for (const double length_m : lengths_m) {
    if (!(length_m > 0)) throw std::invalid_argument("the lengths of segments must be positive");
    Sum sum;
    for (std::size_t i = 0; i < distances.size(); i += static_cast<std::size_t>(step)) {
      const auto end = std::upper_bound(distances.begin(), distances.end(), distances[i] + length_m);
      if (end == distances.end()) break;
      const auto j = static_cast<std::size_t>(end - distances.begin());
      const SE3 error = scaled(motion(pairs.estimate, i, j), scale).inverse() * motion(pairs.truth, i, j);
      sum += {error.t.norm() / length_m, rotation_angle_rad(error.R) / length_m, 1};
    }
    all += sum;
    result.lengths.push_back({length_m, sum.mean()});
  }
  result.all = all.mean();
  return result;
}

std::vector<double> segment_lengths_m(double path_length_m) {
  if (path_length_m < 100) return {10, 20, 30, 40, 50};
  return {100, 200, 300, 400, 500, 600, 700, 800};
}

}  // namespace pavo
