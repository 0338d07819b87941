// The odometry hears of the map's scale some frames late: what it tells until then is in the unit that it knew.
#include <gtest/gtest.h>

#include "stages/map/metric_map.h"

namespace pavo::test {
namespace {

const Camera kPinhole{.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240};

KeyframeRecord keyframe(std::int64_t frame, const SE3& T_last_c, double unit) {
  KeyframeRecord record;
  record.is_keyframe = record.followed = true;
  record.restart = frame == 0;
  record.frame = frame;
  record.T_last_c = {T_last_c.R, T_last_c.t / unit};
  record.unit = unit;
  return record;
}

SE3 ahead(double metres) {
  return {Eigen::Matrix3d::Identity(), Eigen::Vector3d(0.1, 0, metres)};
}

TEST(Units, OfAKeyframeAreTheMaps) {
  LocalMap map(kPinhole, {});
  map.add(keyframe(0, SE3{}, 1));
  map.add(keyframe(1, ahead(1), 1));
  map.rescale(2);
  const Eigen::Vector3d before = map.newest_pose().t;
  map.add(keyframe(2, ahead(2), 0.5), 0.5);  // told as 4 of something that is half a unit
  EXPECT_TRUE((map.newest_pose().t - before).isApprox(ahead(2).t)) << map.newest_pose().t.transpose();
}

// The sensor says that the baselines are three times what the map has: each update tells the whole of it, so that one
// that never came (live, the newest is taken) takes nothing along.
TEST(Units, AreToldAsAWhole) {
  MetricMap map(kPinhole, {});
  const Image none;
  const People nobody;
  MapUpdate update;
  ASSERT_TRUE(map(keyframe(0, SE3{}, 1), none, nobody, update));
  EXPECT_EQ(update.unit, 1);
  double before = 1;
  for (std::int64_t k = 1; k < 4; ++k) {
    KeyframeRecord record = keyframe(k, ahead(1), 1);
    record.baseline_m = 3 * record.T_last_c.t.norm();
    record.baseline_log_sigma = 0.1;
    ASSERT_TRUE(map(record, none, nobody, update));
    EXPECT_GE(update.unit, before);
    before = update.unit;
  }
  EXPECT_NEAR(update.unit, 3, 0.1);
}

TEST(Units, OfANewMapAreWhatItsFirstKeyframeSays) {
  MetricMap map(kPinhole, {});
  const Image none;
  const People nobody;
  MapUpdate update;
  KeyframeRecord restart = keyframe(0, SE3{}, 7);
  ASSERT_TRUE(map(restart, none, nobody, update));
  EXPECT_EQ(update.unit, 7);
}

TEST(Units, FramesBetweenKeyframesPublishNothing) {
  MetricMap map(kPinhole, {});
  const Image none;
  const People nobody;
  MapUpdate update;
  ASSERT_TRUE(map(keyframe(0, SE3{}, 1), none, nobody, update));
  KeyframeRecord between = keyframe(1, ahead(1), 1);
  between.is_keyframe = false;
  EXPECT_FALSE(map(between, none, nobody, update));
}

}  // namespace
}  // namespace pavo::test
