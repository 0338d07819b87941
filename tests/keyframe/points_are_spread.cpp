// One point a cell, wherever in the picture.
#include <gtest/gtest.h>

#include "stages/keyframe/point_grid.h"

namespace pavo::test {
namespace {

int taken(PointGrid& grid, int width, int height, float step) {
  int count = 0;
  for (float y = 0; y < static_cast<float>(height); y += step)
    for (float x = 0; x < static_cast<float>(width); x += step) count += grid.take(x, y);
  return count;
}

TEST(PointGrid, TakesAboutAsManyPointsAsThereMayBe) {
  PointGrid grid(1226, 370, 500, 12);
  const int all = taken(grid, 1226, 370, 1);
  EXPECT_GE(all, 500);
  EXPECT_LE(all, 560);  // cells at the edges are cut
  EXPECT_EQ(taken(grid, 1226, 370, 1), 0) << "all are taken";
  grid.clear();
  EXPECT_EQ(taken(grid, 1226, 370, 1), all);
}

TEST(PointGrid, KeepsTheLeastDistanceInASmallPicture) {
  PointGrid grid(160, 48, 500, 12);
  EXPECT_EQ(taken(grid, 160, 48, 0.5F), 14 * 4);
}

TEST(PointGrid, HasACellForEveryPixel) {
  for (const int width : {1, 17, 640, 1226})
    for (const int height : {1, 31, 480}) {
      PointGrid grid(width, height, 500, 12);
      const auto right = static_cast<float>(width) - 0.001F, bottom = static_cast<float>(height) - 0.001F;
      EXPECT_TRUE(grid.take(right, bottom));
      EXPECT_TRUE(grid.is_taken(right, bottom));
      EXPECT_FALSE(grid.take(right, bottom));
    }
}

}  // namespace
}  // namespace pavo::test
