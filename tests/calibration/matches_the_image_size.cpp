#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/calibration/calibration.h"
#include "tests/calibration/error_of.h"

namespace pavo {
namespace {

using test::error_of;
using testing::HasSubstr;

Calibration kitti() {
  return parse_calibration("P0: 700 0 600 0 0 701 180 0 0 0 1 0\n", "calib.txt");
}

TEST(MatchImageSize, FillsTheSizeThatTheFileDoesNotHave) {
  Calibration calibration = kitti();
  match_image_size(calibration, 1226, 370, "000000.png");
  EXPECT_EQ(calibration.camera.width, 1226);
  EXPECT_EQ(calibration.camera.height, 370);
}

TEST(MatchImageSize, RefusesAPrincipalPointFarOutsideTheImage) {
  Calibration calibration = kitti();
  EXPECT_THAT(
      error_of([&] { match_image_size(calibration, 160, 120, "000000.png"); }),
      HasSubstr("calib.txt, P0: the camera has its principal point at (600, 180), far outside the image of 160x120"));
}

TEST(MatchImageSize, RefusesAnotherSize) {
  Calibration calibration = kitti();
  calibration.camera.width = 1242;
  calibration.camera.height = 375;
  EXPECT_THAT(error_of([&] { match_image_size(calibration, 1226, 370, "000000.png"); }),
              HasSubstr("is for images of 1242x375, but 000000.png has 1226x370"));
  EXPECT_NO_THROW(match_image_size(calibration, 1242, 375, "000000.png"));
}

}  // namespace
}  // namespace pavo
