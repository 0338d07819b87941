// Cells of the picture in which points did not stand still.
#include <gtest/gtest.h>

#include "stages/keyframe/carried_along.h"

namespace pavo::test {
namespace {

TEST(CarriedAlong, OnePointIsNoCar) {
  CarriedAlong carried(1226, 370);
  carried.add(600, 250);
  EXPECT_FALSE(carried.holds(600, 250));
  carried.add(605, 255);
  EXPECT_TRUE(carried.holds(600, 250));
}

TEST(CarriedAlong, ReachesUpButNotDownOrAside) {
  CarriedAlong carried(1600, 800);  // cells of 100 x 100 px
  for (int i = 0; i < 3; ++i) carried.add(850, 650);
  EXPECT_TRUE(carried.holds(801, 601));
  EXPECT_TRUE(carried.holds(850, 550));
  EXPECT_TRUE(carried.holds(850, 401));
  EXPECT_FALSE(carried.holds(850, 399));
  EXPECT_FALSE(carried.holds(850, 701));
  EXPECT_FALSE(carried.holds(799, 650));
  EXPECT_FALSE(carried.holds(901, 650));
}

TEST(CarriedAlong, IsForgottenWithTime) {
  CarriedAlong carried(640, 480);
  for (int i = 0; i < 4; ++i) carried.add(320, 400);
  int frames = 0;
  for (; carried.holds(320, 400); ++frames) carried.fade();
  EXPECT_GT(frames, 5);
  EXPECT_LT(frames, 50);
  for (int i = 0; i < 4; ++i) carried.add(320, 400);
  carried.forget();
  EXPECT_FALSE(carried.holds(320, 400));
}

TEST(CarriedAlong, HasACellForEveryPixel) {
  for (const int width : {1, 17, 1226})
    for (const int height : {1, 5, 370}) {
      CarriedAlong carried(width, height);
      const auto right = static_cast<float>(width) - 0.001F, bottom = static_cast<float>(height) - 0.001F;
      for (int i = 0; i < 2; ++i) carried.add(right, bottom);
      EXPECT_TRUE(carried.holds(right, bottom));
    }
}

}  // namespace
}  // namespace pavo::test
