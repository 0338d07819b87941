#include <gtest/gtest.h>

#include "stages/keyframe/refine_pose.h"
#include "tests/pose/scenes.h"

namespace pavo::test {
namespace {

struct Seen {
  SE3 T_w_c = motion({0.01, 0.03, -0.005}, {0.1, -0.05, 0.9});
  std::vector<PoseConstraint> constraints;
};

// Points in front of the origin, seen from a second place; `sigma_rho` relative to rho.
Seen seen(std::uint64_t seed, double noise_px, double sigma_rho, double outliers) {
  Random random(seed);
  Seen s;
  while (s.constraints.size() < 200) {
    const double x = kCamera.width * random.uniform(), y = kCamera.height * random.uniform();
    const double depth = 4 + 40 * random.uniform();
    const Eigen::Vector3d p = s.T_w_c.inverse() * unproject(x, y, depth);
    if (p.z() < 1 || !inside(project(p))) continue;
    PoseConstraint c;
    c.ray = {Eigen::Vector3d::Zero(), unproject(x, y, 1), 1 / depth, sigma_rho / depth};
    c.ray.rho *= 1 + sigma_rho * gauss(random);
    const double noise = random.uniform() < outliers ? 40 : noise_px;
    c.pixel = project(p) + noise * Eigen::Vector2d(gauss(random), gauss(random));
    c.sigma_px = std::max(noise_px, 0.05);
    s.constraints.push_back(c);
  }
  return s;
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
  Seen s = seen(3, 0.1, 1e-9, 0);
  for (PoseConstraint& c : s.constraints) c.ray.rho = 0.05, c.ray.sigma_rho = 10;
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
