#include "drivers/sequences/groundtruth.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace pavo {
namespace {

Trajectory two_samples(std::int64_t gap_ns) {
  Trajectory trajectory;
  trajectory.T_w_c = {{Eigen::Matrix3d::Identity(), {0, 0, 0}},
                      {Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitY()).toRotationMatrix(), {4, 0, 8}}};
  trajectory.t_ns = {1'000'000'000, 1'000'000'000 + gap_ns};
  return trajectory;
}

TEST(PoseAt, LiesBetweenItsNeighbours) {
  const auto pose = pose_at(two_samples(100'000'000), 1'025'000'000);
  ASSERT_TRUE(pose);
  EXPECT_LT((pose->t - Eigen::Vector3d(1, 0, 2)).norm(), 1e-12);
  EXPECT_LT((pose->R - Eigen::AngleAxisd(0.25, Eigen::Vector3d::UnitY()).toRotationMatrix()).norm(), 1e-12);
}

TEST(PoseAt, SamplesAreMetExactly) {
  const Trajectory samples = two_samples(100'000'000);
  EXPECT_EQ(pose_at(samples, 1'000'000'000)->t.x(), 0);
  EXPECT_NEAR(pose_at(samples, 1'100'000'000)->t.x(), 4, 1e-12);
}

TEST(PoseAt, NothingIsInventedOutsideNorInGaps) {
  const Trajectory samples = two_samples(100'000'000);
  EXPECT_FALSE(pose_at(samples, 990'000'000));
  EXPECT_FALSE(pose_at(samples, 1'110'000'000));
  EXPECT_TRUE(pose_at(samples, 1'000'000'000 - kSameTime_ns)) << "files round their times";
  EXPECT_TRUE(pose_at(samples, 1'100'000'000 + kSameTime_ns));
  const Trajectory gap = two_samples(kLongestGap_ns + 1);
  EXPECT_FALSE(pose_at(gap, 1'100'000'000));
  EXPECT_TRUE(pose_at(gap, 1'000'000'000));
  EXPECT_TRUE(pose_at(gap, 1'000'000'000 + kLongestGap_ns + 1));
  EXPECT_FALSE(pose_at(Trajectory{}, 5));
}

}  // namespace
}  // namespace pavo
