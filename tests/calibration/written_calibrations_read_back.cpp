// What is written as ROS, EuRoC or KITTI is read as the same camera, to the bit.
#include <gtest/gtest.h>

#include "drivers/calibration/calibration.h"
#include "drivers/calibration/write_calibration.h"

namespace pavo {
namespace {

void expect_same(const Camera& a, const Camera& b) {
  EXPECT_EQ(a.fx, b.fx);
  EXPECT_EQ(a.fy, b.fy);
  EXPECT_EQ(a.cx, b.cx);
  EXPECT_EQ(a.cy, b.cy);
  EXPECT_EQ(a.lens, b.lens);
  EXPECT_EQ(a.distortion, b.distortion);
}

Camera camera(Lens lens, const std::array<double, 8>& distortion) {
  return {752, 480, 421.5684054678479, 1e3 / 3, 353.86470067436517, 251.75902411113844, lens, distortion};
}

TEST(WrittenCalibrations, ReadBackTheSameBits) {
  const std::vector<Camera> cameras{
      camera(Lens::rectified, {}),
      camera(Lens::radial_tangential, {-1. / 3, 0.16597404003065688, -6e-4, -1e-300}),
      camera(Lens::radial_tangential, {-1. / 3, 0.1, -6e-4, 0, -0.054}),
      camera(Lens::radial_tangential, {-1. / 3, 0.1, -6e-4, 0, 0, 1e-3, 0, 2. / 3}),
      camera(Lens::equidistant, {-0.02, 0.004, -0.001, 1e-17}),
      camera(Lens::equidistant, {}),
  };
  for (const Camera& c : cameras) {
    const Calibration ros = parse_calibration(ros_camera_info(c, "front_1"), "ros");
    expect_same(ros.camera, c);
    EXPECT_EQ(ros.camera.width, 752);
    const Calibration euroc = parse_calibration(euroc_sensor(c, 20), "euroc");
    expect_same(euroc.camera, c);
    EXPECT_EQ(euroc.camera.height, 480);
    EXPECT_FALSE(euroc.T_b_c);
  }
}

TEST(WrittenCalibrations, OfKittiAreForRectifiedCameras) {
  const Camera c = camera(Lens::rectified, {});
  const std::string text = kitti_projections(c);
  for (int n = 0; n < 4; ++n) expect_same(parse_calibration(text, "kitti", {.kitti_camera = n}).camera, c);
  EXPECT_THROW(kitti_projections(camera(Lens::equidistant, {})), std::invalid_argument);
}

}  // namespace
}  // namespace pavo
