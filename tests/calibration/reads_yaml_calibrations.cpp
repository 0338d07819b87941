#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <opencv2/core.hpp>

#include "drivers/calibration/calibration.h"
#include "tests/calibration/error_of.h"
#include "tests/support/data.h"

namespace pavo {
namespace {

using testing::HasSubstr;
using Distortion = std::array<double, 8>;

const std::string kEuroc = R"(%YAML:1.0
sensor_type: camera
T_BS:
  cols: 4
  rows: 4
  data: [0, -1, 0, 0.1,
         1, 0, 0, 0.2,
         0, 0, 1, 0.3,
         0.0, 0.0, 0.0, 1.0]
rate_hz: 20
resolution: [752, 480]
camera_model: pinhole
intrinsics: [458.654, 457.296, 367.215, 248.375] #fu, fv, cu, cv
distortion_model: radial-tangential
distortion_coefficients: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]
)";

const std::string kRos = R"(image_width: 640
image_height: 480
camera_name: head
camera_matrix:
  rows: 3
  cols: 3
  data: [500.5, 0, 320.25, 0, 501.5, 240.75, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0.1, -0.2, 0.003, 0.004, 0.05]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [450, 0, 321, 0, 0, 451, 241, 0, 0, 0, 1, 0]
)";

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

TEST(EurocCalibration, RadialTangentialWithThePlaceOfTheCameraInTheBody) {
  const Calibration c = parse_calibration(kEuroc, "sensor.yaml");
  EXPECT_EQ(c.camera.width, 752);
  EXPECT_EQ(c.camera.height, 480);
  EXPECT_EQ(c.camera.fx, 458.654);
  EXPECT_EQ(c.camera.fy, 457.296);
  EXPECT_EQ(c.camera.cx, 367.215);
  EXPECT_EQ(c.camera.cy, 248.375);
  EXPECT_EQ(c.camera.lens, Lens::radial_tangential);
  EXPECT_EQ(c.camera.distortion, (Distortion{-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}));
  ASSERT_TRUE(c.T_b_c);
  EXPECT_EQ(c.T_b_c->t, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_LT((*c.T_b_c * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0.1, 1.2, 0.3)).norm(), 1e-14);
}

TEST(EurocCalibration, EquidistantFisheye) {
  const Calibration c = parse_calibration(replaced(kEuroc, "radial-tangential", "equidistant"), "sensor.yaml");
  EXPECT_EQ(c.camera.lens, Lens::equidistant);
  EXPECT_EQ(c.camera.distortion[3], 1.76187114e-05);
}

TEST(EurocCalibration, NoDistortionIsARectifiedCamera) {
  const std::string none = replaced(
      kEuroc, "radial-tangential\ndistortion_coefficients: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]",
      "none");
  EXPECT_EQ(parse_calibration(none, "sensor.yaml").camera.lens, Lens::rectified);
  const std::string zeros = replaced(kEuroc, "[-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]", "[0, 0, 0, 0]");
  EXPECT_EQ(parse_calibration(zeros, "sensor.yaml").camera.lens, Lens::rectified);
}

TEST(EurocCalibration, AFisheyeWithoutDistortionStaysAFisheye) {
  std::string zeros = replaced(kEuroc, "[-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]", "[0, 0, 0, 0]");
  zeros = replaced(zeros, "radial-tangential", "equidistant");
  EXPECT_EQ(parse_calibration(zeros, "sensor.yaml").camera.lens, Lens::equidistant);
}

TEST(RosCalibration, IsOfTheRawImage) {
  const Calibration c = parse_calibration(kRos, "camera.yaml");
  EXPECT_EQ(c.camera.fx, 500.5) << "K, not P";
  EXPECT_EQ(c.camera.cy, 240.75);
  EXPECT_EQ(c.camera.distortion, (Distortion{0.1, -0.2, 0.003, 0.004, 0.05}));
  EXPECT_THAT(c.source, HasSubstr("camera_matrix and distortion of the raw image (not P)"));
}

TEST(RosCalibration, RationalPolynomialAndFisheye) {
  std::string rational = replaced(kRos, "plumb_bob", "rational_polynomial");
  rational = replaced(rational, "cols: 5\n  data: [0.1, -0.2, 0.003, 0.004, 0.05]",
                      "cols: 8\n  data: [1, 2, 3, 4, 5, 6, 7, 8]");
  EXPECT_EQ(parse_calibration(rational, "c").camera.distortion, (Distortion{1, 2, 3, 4, 5, 6, 7, 8}));
  for (const char* name : {"equidistant", "fisheye"}) {
    std::string fisheye = replaced(kRos, "plumb_bob", name);
    fisheye = replaced(fisheye, "cols: 5\n  data: [0.1, -0.2, 0.003, 0.004, 0.05]", "cols: 4\n  data: [1, 2, 3, 4]");
    EXPECT_EQ(parse_calibration(fisheye, "c").camera.lens, Lens::equidistant);
  }
}

TEST(RosCalibration, AsRostopicEchoPrintsIt) {
  const std::string text =
      "header:\n  seq: 1\nheight: 480\nwidth: 640\ndistortion_model: \"plumb_bob\"\nD: [0.0, 0.0, 0.0, 0.0, 0.0]\n"
      "K: [500.0, 0.0, 320.0, 0.0, 500.0, 240.0, 0.0, 0.0, 1.0]\nbinning_x: 0\nbinning_y: 0\n---\n";
  const Calibration c = parse_calibration(text, "echo.yaml");
  EXPECT_EQ(c.camera.fx, 500);
  EXPECT_EQ(c.camera.lens, Lens::rectified);
}

/// What cv::FileStorage writes, read by us, is what went in: for each usual spelling of the keys.
TEST(OpenCvCalibration, FileStorageRoundTrip) {
  const cv::Matx33d K(420.51, 0, 355.21, 0, 420.61, 250.34, 0, 0, 1);
  const cv::Mat D = (cv::Mat_<double>(1, 5) << -0.2967, 0.0809, 1e-5, -2.5e-7, 0);
  struct Keys {
    const char *width, *height, *matrix, *distortion;
  };
  for (const Keys keys :
       {Keys{"image_width", "image_height", "camera_matrix", "distortion_coefficients"},
        Keys{"image_Width", "image_Height", "Camera_Matrix", "Distortion_Coefficients"},
        Keys{"imageWidth", "imageHeight", "cameraMatrix", "distCoeffs"}, Keys{"width", "height", "K", "D"}}) {
    cv::FileStorage storage("calibration.yml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
    storage << "calibration_time"
            << "Sun Nov 22 2026" << keys.width << 752 << keys.height << 480;
    storage << keys.matrix << cv::Mat(K) << keys.distortion << D << "avg_reprojection_error" << 0.2;
    const std::string text = storage.releaseAndGetString();
    const Calibration c = parse_calibration(text, "calibration.yml");
    EXPECT_EQ(c.camera.width, 752) << text;
    EXPECT_EQ(c.camera.height, 480);
    EXPECT_EQ(c.camera.fx, K(0, 0));
    EXPECT_EQ(c.camera.fy, K(1, 1));
    EXPECT_EQ(c.camera.cx, K(0, 2));
    EXPECT_EQ(c.camera.cy, K(1, 2));
    for (int i = 0; i < 5; ++i) EXPECT_EQ(c.camera.distortion[static_cast<std::size_t>(i)], D.at<double>(i));
    EXPECT_EQ(c.camera.lens, Lens::radial_tangential);
  }
}

TEST(OpenCvCalibration, FisheyeModel) {
  cv::FileStorage storage("calibration.yml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  storage << "image_width" << 640 << "image_height" << 480 << "fisheye_model" << 1;
  storage << "camera_matrix" << cv::Mat(cv::Matx33d(300, 0, 320, 0, 300, 240, 0, 0, 1));
  storage << "distortion_coefficients" << (cv::Mat_<double>(4, 1) << 0.1, 0.2, 0.3, 0.4);
  const Calibration c = parse_calibration(storage.releaseAndGetString(), "calibration.yml");
  EXPECT_EQ(c.camera.lens, Lens::equidistant);
  EXPECT_EQ(c.camera.distortion, (Distortion{0.1, 0.2, 0.3, 0.4}));
}

TEST(EurocCalibration, OfTheRealSequence) {
  PAVO_NEEDS_DATA("sequences/euroc-standstill-25/mav0/cam0/sensor.yaml");
  const auto path = test::data_folder() / "sequences" / "euroc-standstill-25" / "mav0" / "cam0" / "sensor.yaml";
  const Calibration c = read_calibration(path.string());
  EXPECT_EQ(c.camera.fx, 458.654);
  EXPECT_EQ(c.camera.width, 752);
  EXPECT_EQ(c.camera.lens, Lens::radial_tangential);
  ASSERT_TRUE(c.T_b_c);
  EXPECT_NEAR(c.T_b_c->R.determinant(), 1, 1e-12);
}

}  // namespace
}  // namespace pavo
