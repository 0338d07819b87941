#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "stages/keyframe/refine_pose.h"
#include "stages/map/refined_camera.h"
#include "tests/pose/scenes.h"
#include "tests/support/simd_targets.h"

namespace pavo::test {
namespace {

struct Seen {
  SE3 T_w_c = motion({0.01, 0.03, -0.005}, {0.1, -0.05, 0.9});
  PoseConstraints constraints;
};

// Points in front of the origin, seen from a second place; `sigma_rho` relative to rho.
std::vector<PoseConstraint> points_seen(const SE3& T_w_c, std::uint64_t seed, double noise_px, double sigma_rho,
                                        double outliers) {
  Random random(seed);
  std::vector<PoseConstraint> points;
  while (points.size() < 200) {
    const double x = kCamera.width * random.uniform(), y = kCamera.height * random.uniform();
    const double depth = 4 + 40 * random.uniform();
    const Eigen::Vector3d p = T_w_c.inverse() * unproject(x, y, depth);
    if (p.z() < 1 || !inside(project(p))) continue;
    PoseConstraint c;
    c.ray = {Eigen::Vector3d::Zero(), unproject(x, y, 1), 1 / depth, sigma_rho / depth};
    c.ray.rho *= 1 + sigma_rho * gauss(random);
    const double noise = random.uniform() < outliers ? 40 : noise_px;
    c.pixel = project(p) + noise * Eigen::Vector2d(gauss(random), gauss(random));
    c.sigma_px = std::max(noise_px, 0.05);
    points.push_back(c);
  }
  return points;
}

PoseConstraints constraints_of(const std::vector<PoseConstraint>& points) {
  PoseConstraints constraints;
  for (const PoseConstraint& point : points) constraints.push_back(point);
  return constraints;
}

Seen seen(std::uint64_t seed, double noise_px, double sigma_rho, double outliers) {
  Seen s;
  s.constraints = constraints_of(points_seen(s.T_w_c, seed, noise_px, sigma_rho, outliers));
  return s;
}

// What the loop over eight points at a time says is what each point says by itself: some of them behind the camera,
// some of unknown depth, the last of a block missing, the lens not quite as calibrated.
TEST(RefinePose, SumsWhatEachPointSays) {
  const Camera camera = refined_camera(kCamera, {0.01, 0.03});
  const SE3 T = motion({0.02, 0.03, -0.01}, {0.15, -0.05, 0.8});
  constexpr double kScale = 3;
  std::vector<PoseConstraint> points = points_seen(T, 5, 0.5, 0.05, 0.2);
  for (std::size_t i = 0; i < points.size(); i += 7) points[i].ray.sigma_rho = 10;
  for (std::size_t i = 3; i < points.size(); i += 50) points[i].ray.direction.z() = -1;
  for (const std::int64_t target : simd_targets())
    for (const std::size_t n : {0, 1, 7, 8, 9, 197}) {
      const ForceTarget force(target);
      const std::vector<PoseConstraint> some(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(n));
      PoseConstraints constraints = constraints_of(some);
      const RefinedPose pose =
          refine_pose(constraints, camera, {.T_w_c = T}, T, {.loss_scale = kScale, .widest = 1, .iterations = 0});
      Matrix6d A = Matrix6d::Zero();
      Vector6d b = Vector6d::Zero();
      double cost = 0;
      for (std::size_t i = 0; i < n; ++i) {
        const RayPoint& ray = some[i].ray;
        const Eigen::Vector3d p = scaled_in_camera(ray, T);
        if (p.z() < 1e-3) {
          cost += kScale * kScale;
          EXPECT_GT(constraints.chi2(i), 1e6);
          continue;
        }
        const Eigen::Matrix<double, 2, 3> by_point = pixel_jacobian(camera, p);
        const Eigen::Vector2d r = pixel_of(camera, p) - some[i].pixel;
        const Eigen::Vector2d g = by_point * T.R.transpose() * (ray.origin - T.t);
        const Eigen::Matrix2d covariance = some[i].sigma_px * some[i].sigma_px * Eigen::Matrix2d::Identity() +
                                           ray.sigma_rho * ray.sigma_rho * g * g.transpose();
        const double chi2 = r.dot(covariance.inverse() * r), shrink = 1 / (1 + chi2 / (kScale * kScale));
        EXPECT_NEAR(constraints.chi2(i), chi2, 1e-6 * chi2 + 1e-9);
        const Eigen::Matrix<double, 2, 6> J = pose_jacobian(by_point, p, ray.rho);
        A += shrink * shrink * J.transpose() * covariance.inverse() * J;
        b += shrink * shrink * J.transpose() * covariance.inverse() * r;
        cost += chi2 * shrink;
      }
      EXPECT_LE((pose.information - A).norm(), 1e-6 * A.norm());
      EXPECT_NEAR(pose.cost * static_cast<double>(std::max<std::size_t>(n, 1)), cost, 1e-6 * cost);
      if (n < 197) continue;
      const SE3 next = refine_pose(constraints, camera, {.T_w_c = T}, T, {.loss_scale = kScale, .iterations = 1}).T_w_c;
      const Vector6d step = A.ldlt().solve(-b);
      EXPECT_LE((step_between(T, next) - step).norm(), 1e-4 * step.norm());
    }
}

TEST(RefinePose, FindsItFromExactPoints) {
  Seen s = seen(1, 0, 1e-9, 0);
  const RefinedPose pose =
      refine_pose(s.constraints, kCamera, {}, SE3{}, {.loss_scale = 3, .widest = 64, .iterations = 20});
  EXPECT_LT(step_between(s.T_w_c, pose.T_w_c).norm(), 1e-3);
  EXPECT_EQ(pose.inliers, 200);
}

TEST(RefinePose, SurvivesOutliers) {
  Seen s = seen(2, 0.3, 0.01, 0.35);
  const RefinedPose pose =
      refine_pose(s.constraints, kCamera, {}, SE3{}, {.loss_scale = 3, .widest = 64, .iterations = 10});
  EXPECT_LT((pose.T_w_c.t - s.T_w_c.t).norm(), 0.03);
  EXPECT_LT(rotation_vector(pose.T_w_c.R.transpose() * s.T_w_c.R).norm(), 1e-3);
}

// Nothing is known of the depths: the direction and the rotation are found all the same, the length stays the prior's.
TEST(RefinePose, KnowsTheDirectionWithoutDepths) {
  Seen s;
  std::vector<PoseConstraint> points = points_seen(s.T_w_c, 3, 0.1, 1e-9, 0);
  for (PoseConstraint& c : points) c.ray.rho = 0.05, c.ray.sigma_rho = 10;
  s.constraints = constraints_of(points);
  PosePrior prior;
  prior.T_w_c.t = {0, 0, 1};
  prior.information << 4, 4, 4, 100, 100, 100;
  const RefinedPose pose =
      refine_pose(s.constraints, kCamera, prior, prior.T_w_c, {.loss_scale = 3, .widest = 16, .iterations = 20});
  EXPECT_LT((pose.T_w_c.t.normalized() - s.T_w_c.t.normalized()).norm(), 0.02);
  EXPECT_LT(rotation_vector(pose.T_w_c.R.transpose() * s.T_w_c.R).norm(), 2e-3);
}

// The covariance that it states is the one that its errors have.
TEST(RefinePose, KnowsHowSureItIs) {
  double nees = 0;
  constexpr int kRuns = 60;
  for (int run = 0; run < kRuns; ++run) {
    Seen s = seen(100 + static_cast<std::uint64_t>(run), 0.4, 0.02, 0);
    const RefinedPose pose =
        refine_pose(s.constraints, kCamera, {}, s.T_w_c, {.loss_scale = 20, .widest = 1, .iterations = 20});
    const Vector6d error = step_between(s.T_w_c, pose.T_w_c);
    nees += error.dot(pose.information * error) / kRuns;
  }
  EXPECT_GT(nees, 4);
  EXPECT_LT(nees, 8.5);
}

}  // namespace
}  // namespace pavo::test
