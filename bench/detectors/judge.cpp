#include "bench/detectors/judge.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "stages/pose/essential.h"

namespace pavo::bench {

std::vector<std::uint8_t> right_ones(const PointPairs& pairs, const Camera& camera, const SE3& T_c_p) {
  const Eigen::Matrix3d K_inverse = intrinsic_matrix(camera).inverse();
  const Eigen::Matrix3d F = K_inverse.transpose() * cross_matrix(T_c_p.t) * T_c_p.R * K_inverse;
  std::vector<std::uint8_t> right;
  for (const PointPair& pair : pairs) {
    const Eigen::Vector3d line = F * Eigen::Vector3d(pair.x_previous, pair.y_previous, 1);
    const double distance =
        std::abs(line.dot(Eigen::Vector3d(pair.x_current, pair.y_current, 1))) / line.head<2>().norm();
    right.push_back(distance <= kRightPx);
  }
  return right;
}

MotionError motion_error(const PointPairs& pairs, const Camera& camera, const FramePair& truth) {
  RelativeMotionEstimator estimate(camera, {});
  std::vector<std::uint8_t> is_inlier;
  const RelativeMotion motion = estimate(pairs, Random::for_frame(0, truth.frame), is_inlier);
  if (!motion.found || motion.quality != Quality::tracked) return {};
  const SE3 T_c_p = motion.T_p_c.inverse();
  constexpr double kDegrees = 57.29577951308232;
  const double cosine = T_c_p.t.normalized().dot(truth.T_c_p.t.normalized());
  return {true, kDegrees * Eigen::AngleAxisd(T_c_p.R * truth.T_c_p.R.transpose()).angle(),
          kDegrees * std::acos(std::clamp(cosine, -1.0, 1.0))};
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto index = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  const auto at = values.begin() + std::min(index, static_cast<std::ptrdiff_t>(values.size()) - 1);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace pavo::bench
