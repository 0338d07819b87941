// Live, the map may be busy when a keyframe comes, which it then never sees: what comes after hangs on an older one.
#include <gtest/gtest.h>

#include "stages/map/local_map.h"
#include "stages/map/metric_map.h"

namespace pavo::test {
namespace {

const Camera kCamera{.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240};

SE3 place(std::int64_t frame) {
  const auto t = static_cast<double>(frame);
  return {Eigen::AngleAxisd(0.02 * t, Eigen::Vector3d::UnitY()).toRotationMatrix(), {0.1 * t, 0, t}};
}

/// The keyframe of `frame`, by an odometry that calls the first keyframe's place `origin` and has those of `before`.
KeyframeRecord keyframe(std::int64_t frame, const std::vector<std::int64_t>& before, const SE3& origin = {}) {
  KeyframeRecord record;
  record.is_keyframe = record.followed = true;
  record.restart = before.empty();
  record.frame = frame;
  record.T_w_c = origin * place(frame);
  for (const std::int64_t k : before) record.before.push_back({k, origin * place(k)});
  record.T_last_c = before.empty() ? record.T_w_c : record.before.back().T_w_c.inverse() * record.T_w_c;
  return record;
}

void expect_near(const SE3& a, const SE3& b) {
  EXPECT_LT((a.t - b.t).norm(), 1e-9) << a.t.transpose() << " and " << b.t.transpose();
  EXPECT_LT((a.R - b.R).norm(), 1e-9);
}

TEST(MissingKeyframes, LeaveTheNextAtItsPlace) {
  LocalMap map(kCamera, {});
  map.add(keyframe(0, {}));
  map.add(keyframe(1, {0}));
  map.add(keyframe(3, {0, 1, 2}));  // 2 was skipped
  expect_near(map.newest_pose(), place(3));
  EXPECT_NEAR(map.newest_baseline(), (place(3).t - place(1).t).norm(), 1e-9);
}

// The odometry has its own world by then: only where the keyframes are to each other counts.
TEST(MissingKeyframes, AreBridgedWhereTheOdometryHasMovedOn) {
  LocalMap map(kCamera, {});
  map.add(keyframe(0, {}));
  const SE3 elsewhere{Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()).toRotationMatrix(), {5, 6, 7}};
  map.add(keyframe(2, {0, 1}, elsewhere));
  expect_near(map.newest_pose(), place(2));
}

TEST(MissingKeyframes, AreBridgedInTheMapsUnit) {
  LocalMap map(kCamera, {});
  map.add(keyframe(0, {}));
  map.rescale(2);
  map.add(keyframe(2, {0, 1}), 2);
  EXPECT_LT((map.newest_pose().t - 2 * place(2).t).norm(), 1e-9);
}

TEST(MissingKeyframes, ThatBeganAMapLetItBeginAnew) {
  LocalMap map(kCamera, {});
  map.add(keyframe(0, {}));
  map.add(keyframe(1, {0}));
  EXPECT_FALSE(map.in_newest(keyframe(12, {10, 11})));  // 10 began a map, after a loss
  map.add(keyframe(12, {10, 11}));
  expect_near(map.newest_pose(), place(12));
  EXPECT_EQ(map.newest_baseline(), 0);
}

// The length that a sensor tells is from the keyframe that is missing.
TEST(MissingKeyframes, TakeTheirLengthAlong) {
  MetricMap map(kCamera, {});
  const Image none;
  const People nobody;
  MapUpdate update;
  ASSERT_TRUE(map(keyframe(0, {}), none, nobody, update));
  KeyframeRecord record = keyframe(2, {0, 1});
  record.baseline_m = record.T_last_c.t.norm();
  record.baseline_log_sigma = 0.01;
  ASSERT_TRUE(map(record, none, nobody, update));
  EXPECT_EQ(update.unit, 1);
  EXPECT_LT(update.scale_variance, 0);
}

}  // namespace
}  // namespace pavo::test
