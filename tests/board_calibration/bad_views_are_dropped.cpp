// A view that was found wrong does not spoil the calibration, and views that cannot tell the camera are refused.
#include <gmock/gmock.h>

#include "stages/calibration/calibrate_camera.h"
#include "tests/board_calibration/boards.h"
#include "tests/support/temporary.h"

namespace pavo::test {
namespace {

using ::testing::HasSubstr;

std::vector<BoardCorners> good_views(int count) {
  std::mt19937 random(2);
  std::vector<BoardCorners> views;
  for (const SE3& pose : poses(pinhole(), count, 6)) views.push_back(corners_seen(pinhole(), pose, 0.1, random));
  return views;
}

CalibrationResult calibrated(const std::vector<BoardCorners>& views, Lens lens = Lens::radial_tangential) {
  return calibrate_camera(views, kBoard, pinhole().width, pinhole().height, lens);
}

TEST(BadViews, AreDroppedAndCounted) {
  std::vector<BoardCorners> views = good_views(10);
  std::mt19937 random(3);
  views[4] = corners_seen(pinhole(), poses(pinhole(), 1, 8).front(), 3, random);  // blurred
  std::swap(views[7][3], views[7][30]);                                           // mistaken
  const CalibrationResult result = calibrated(views);
  EXPECT_EQ(result.used, 8);
  ASSERT_EQ(result.views.size(), 10u);
  for (std::size_t v = 0; v < views.size(); ++v) {
    EXPECT_EQ(result.views[v].used, v != 4 && v != 7) << v;
    EXPECT_EQ(result.views[v].rms_px > 0.5, v == 4 || v == 7) << v;
  }
  EXPECT_NEAR(result.camera.fx, pinhole().fx, 4 * result.sigma.fx);
}

TEST(BadViews, AreNeverMoreThanHalf) {
  std::vector<BoardCorners> views = good_views(6);
  std::mt19937 random(3);
  for (std::size_t v = 0; v < 4; ++v)
    views[v] = corners_seen(pinhole(), poses(pinhole(), 6, 6)[v], 5 * static_cast<double>(v + 1), random);
  EXPECT_GE(calibrated(views).used, 3);
}

TEST(BadViews, TooFewAreRefused) {
  for (const int count : {0, 1, 2})
    EXPECT_THAT(complaint([&] { calibrated(good_views(count)); }), HasSubstr("expected 3 or more")) << count;
}

// A board that always faces the camera says nothing of the focal length.
TEST(BadViews, ThatAllFaceTheCameraAreRefused) {
  std::mt19937 random(4);
  for (const Lens lens : {Lens::radial_tangential, Lens::equidistant}) {
    Camera camera = lens == Lens::equidistant ? fisheye() : pinhole();
    camera.distortion = {};
    std::vector<BoardCorners> views;
    for (int i = 0; i < 6; ++i)
      views.push_back(corners_seen(camera, {Eigen::Matrix3d::Identity(), {-0.1, -0.08, 0.3}}, 0.1, random));
    const std::string error = complaint([&] { calibrate_camera(views, kBoard, camera.width, camera.height, lens); });
    const bool bend_tells = lens == Lens::equidistant;  // a fisheye's does, roughly
    EXPECT_TRUE(bend_tells || error.find("tilted to all sides") != std::string::npos) << error;
  }
}

TEST(BadViews, OfNothingButOnePointAreRefused) {
  const std::vector<BoardCorners> views(5, BoardCorners(static_cast<std::size_t>(kBoard.corners()), {10, 10}));
  for (const Lens lens : {Lens::radial_tangential, Lens::equidistant})
    EXPECT_THAT(complaint([&] { calibrated(views, lens); }), HasSubstr("do not determine"));
}

}  // namespace
}  // namespace pavo::test
