// How sure a pose is: from the points it was estimated with, how well they fit, and how long each of them is there.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "stages/keyframe/odometry_state.h"
#include "stages/pose/essential.h"

namespace pavo {
namespace {

constexpr double kMedianOfTwo = 1.386, kMedianOfOne = 0.455;  // of chi-square, by its degrees of freedom

// More than this a point's error never lasts, and less than this it is no point of the map.
constexpr double kLongestLife = 50, kShortestLife = 2;

// What a generation of points adds, over what it would if its points had nothing in common: their patches are drawn
// larger, not warped, and some of them slide along edges. By bench_consistency, over 100 drives.
constexpr double kInCommon = 1.8;

Matrix6d of_diagonal(double variance_t, double variance_r) {
  Vector6d d;
  d << Eigen::Vector3d::Constant(variance_t), Eigen::Vector3d::Constant(variance_r);
  return d.asDiagonal();
}

}  // namespace

// A pixel's variance over what options.sigma_px takes it for, by the median of the squared residuals of what fits,
// smoothed over some frames.
double KeyframeOdometry::State::pixel_variance(double median_chi2) {
  constexpr double kGain = 0.1;
  scratch.clear();
  for (std::size_t i = 0; i < constraints.size(); ++i)
    if (constraints.chi2(i) < 9) scratch.push_back(static_cast<float>(constraints.chi2(i)));
  if (scratch.size() < 10) return noise_ratio > 0 ? noise_ratio : 1;
  const auto middle = scratch.begin() + static_cast<std::ptrdiff_t>(scratch.size() / 2);
  std::nth_element(scratch.begin(), middle, scratch.end());
  const double now = static_cast<double>(*middle) / median_chi2;
  noise_ratio = noise_ratio > 0 ? noise_ratio + kGain * (now - noise_ratio) : now;
  return noise_ratio;
}

void KeyframeOdometry::State::tell_uncertainty(const RefinedPose& pose) {
  const Matrix6d noise = pixel_variance(kMedianOfTwo) * pose.information.inverse();
  double seen = 0;
  int points_seen = 0;
  for (std::size_t n = 0; n < constrained.size(); ++n) {
    if (constraints.chi2(n) > 9) continue;
    seen += points[static_cast<std::size_t>(constrained[n])].seen;
    ++points_seen;
  }
  const double life = std::clamp(seen / std::max(1, points_seen), kShortestLife, kLongestLife);
  uncertainty.step(last_T, pose.T_w_c, kInCommon / life * noise, noise);
}

void KeyframeOdometry::State::begin_scale(bool told) {
  constexpr double kSensor = 0.03, kMotionModel = 0.1;
  has_scale = true;
  if (!step_length->metric())
    uncertainty.begin_scale(next_id > 1 ? kMotionModel : 0);  // the first baseline is the unit itself
  else
    uncertainty.begin_scale(told ? kSensor : scale_known ? kMotionModel : options.unknown_log_sigma);
}

// Without a map every pair says on which epipolar line it lies, so nothing about the way's length: that is the scale's.
void KeyframeOdometry::State::tell_uncertainty_of_start(const SE3& T_r_c, const PoseResult& out) {
  constexpr double kUnknownDepth = 1e3, kLengthKnown = 1e-3;
  // Beside this image's noise, the first one's; and what came nearer is aligned here as it was, which puts points of a
  // region off by the same.
  constexpr double kBothImages = 2.3;
  const double length = T_r_c.t.norm();
  constraints.clear();
  for (std::size_t i = 0; i < out.pairs.size(); ++i) {
    if (!out.is_inlier[i]) continue;
    const PointPair& pair = out.pairs[i];
    const Eigen::Vector3d ray((pair.x_previous - camera.cx) / camera.fx, (pair.y_previous - camera.cy) / camera.fy, 1);
    const Eigen::Vector3d ray_c((pair.x_current - camera.cx) / camera.fx, (pair.y_current - camera.cy) / camera.fy, 1);
    const double depth = length > 0 ? triangulate_depths(T_r_c.inverse(), ray, ray_c).previous : 0;
    constraints.push_back({.ray = {Eigen::Vector3d::Zero(), ray, depth > 0 ? 1 / depth : 0, kUnknownDepth},
                           .pixel = {pair.x_current, pair.y_current},
                           .sigma_px = options.sigma_px});
  }
  RefinedPose there =
      refine_pose(constraints, camera, {.T_w_c = T_r_c}, T_r_c, {.loss_scale = 2.5, .widest = 1, .iterations = 0});
  Matrix6d A = there.information / (kBothImages * kBothImages * pixel_variance(kMedianOfOne));
  if (length > 0) {
    const Eigen::Vector3d along = T_r_c.R.transpose() * T_r_c.t / length;
    A.topLeftCorner<3, 3>() += along * along.transpose() / std::pow(kLengthKnown * length, 2);
  }
  A.diagonal().head<3>().array() += 1 / std::pow(std::max(length, 1e-3), 2);
  A.diagonal().tail<3>().array() += 1;
  uncertainty.step(last_T, reference_T * T_r_c, Matrix6d::Zero(), A.inverse());
}

// The motion model's: a third of the step, and some rotation.
void KeyframeOdometry::State::guess_uncertainty(const PoseResult& out) {
  const SE3 step = last_T.inverse() * out.T_w_c;
  const double sigma_t = 0.3 * step.t.norm(), sigma_r = 0.3 * rotation_vector(step.R).norm() + (started ? 2e-3 : 0);
  uncertainty.coast(last_T, out.T_w_c, of_diagonal(sigma_t * sigma_t, sigma_r * sigma_r));
}

}  // namespace pavo
