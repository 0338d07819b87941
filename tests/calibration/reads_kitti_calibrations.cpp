#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/calibration/calibration.h"
#include "drivers/calibration/kitti_file.h"
#include "tests/calibration/error_of.h"
#include "tests/support/data.h"

namespace pavo {
namespace {

using test::error_of;
using testing::HasSubstr;

const std::string kOdometry =
    "P0: 700 0 600 0 0 701 180 0 0 0 1 0\n"
    "P1: 700 0 600 -380 0 701 180 0 0 0 1 0\r\n"
    "P2: 710 0 601 46 0 711 181 0.1 0 0 1 0.006\n"
    "Tr: 1 0 0 0 0 1 0 0 0 0 1 0\n";

std::string raw(const std::string& n) {
  return "S_0" + n + ": 1.392000e+03 5.120000e+02\nK_0" + n + ": 984 0 690 0 981 233 0 0 1\nD_0" + n +
         ": -0.37 0.2 0.001 0.002 -0.07\nS_rect_0" + n + ": 1.242000e+03 3.750000e+02\nP_rect_0" + n +
         ": 721 0 609 44 0 721 172 0.2 0 0 1 0.003\n";
}

const std::string kRaw = "calib_time: 09-Jan-2012 13:57:47\ncorner_dist: 9.950000e-02\n" + raw("0") + raw("2");

TEST(KittiCalibration, TheImageFolderPicksTheProjection) {
  const Calibration gray = parse_calibration(kOdometry, "calib.txt", {0});
  EXPECT_EQ(gray.camera.fx, 700);
  EXPECT_EQ(gray.camera.fy, 701);
  EXPECT_EQ(gray.camera.cx, 600);
  EXPECT_EQ(gray.camera.cy, 180);
  EXPECT_EQ(gray.camera.lens, Lens::rectified);
  EXPECT_EQ(gray.camera.width, 0) << "calib.txt has no image size";
  EXPECT_EQ(gray.source, "calib.txt, P0");

  const Calibration colour = parse_calibration(kOdometry, "calib.txt", {2});
  EXPECT_EQ(colour.camera.fx, 710);
  EXPECT_EQ(colour.camera.cy, 181);
  EXPECT_EQ(colour.source, "calib.txt, P2");
}

TEST(KittiCalibration, WithoutAFolderItIsTheFirstOrTheOnlyCamera) {
  EXPECT_EQ(parse_calibration(kOdometry, "calib.txt").source, "calib.txt, P0");
  EXPECT_EQ(parse_calibration("P2: 700 0 600 0 0 701 180 0 0 0 1 0\n", "calib.txt").source, "calib.txt, P2");
  EXPECT_THAT(
      error_of([] { parse_calibration("P1: 7 0 6 0 0 7 1 0 0 0 1 0\nP2: 7 0 6 0 0 7 1 0 0 0 1 0\n", "calib.txt"); }),
      HasSubstr("calib.txt:2: has several cameras but no P0"));
}

TEST(KittiCalibration, AMissingCameraIsNotReplacedByAnother) {
  EXPECT_THAT(error_of([] { parse_calibration(kOdometry, "calib.txt", {3}); }), HasSubstr("calib.txt: has no P3"));
}

TEST(KittiCalibration, RawDrivesAreRectified) {
  const Calibration c = parse_calibration(kRaw, "calib_cam_to_cam.txt", {2, 1242, 375});
  EXPECT_EQ(c.camera.fx, 721);
  EXPECT_EQ(c.camera.width, 1242);
  EXPECT_EQ(c.camera.height, 375);
  EXPECT_EQ(c.camera.lens, Lens::rectified);
  EXPECT_EQ(c.source, "calib_cam_to_cam.txt, P_rect_02");
}

TEST(KittiCalibration, ImagesOfTheSensorsSizeAreBeforeRectification) {
  const Calibration c = parse_calibration(kRaw, "calib_cam_to_cam.txt", {0, 1392, 512});
  EXPECT_EQ(c.camera.fx, 984);
  EXPECT_EQ(c.camera.width, 1392);
  EXPECT_EQ(c.camera.lens, Lens::radial_tangential);
  EXPECT_EQ(c.camera.distortion, (std::array<double, 8>{-0.37, 0.2, 0.001, 0.002, -0.07, 0, 0, 0}));
  EXPECT_THAT(c.source, HasSubstr("K_00 and D_00"));
}

TEST(KittiFile, RotationsThatWereRoundedBecomeRotations) {
  const KittiFile file("R: 0.99999 -0.00447 0 0.00447 0.99999 0 0 0 1\nT: 1 2 3\n", "calib");
  const SE3 motion = file.motion("R", "T");
  EXPECT_LT((motion.R.transpose() * motion.R - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_EQ(motion.t, Eigen::Vector3d(1, 2, 3));
  const KittiFile mirrored("R: 1 0 0 0 1 0 0 0 -1\n", "calib");
  EXPECT_THAT(error_of([&] { mirrored.rotation("R"); }), HasSubstr("calib:1: R is not a rotation"));
}

TEST(KittiCalibration, OfTheRealSequences) {
  PAVO_NEEDS_DATA("sequences/kitti-city-134/calib.txt");
  const auto path = test::data_folder() / "sequences" / "kitti-city-134" / "calib.txt";
  const Calibration c = read_calibration(path.string(), {2});
  EXPECT_DOUBLE_EQ(c.camera.fx, 721.5377);
  EXPECT_DOUBLE_EQ(c.camera.cy, 172.8540);
}

}  // namespace
}  // namespace pavo
