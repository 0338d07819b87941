// Corners with noise that is known, many times over: the parameters scatter as much as they are said to.
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>

#include "stages/calibration/bundle.h"
#include "stages/calibration/calibrate_camera.h"
#include "tests/board_calibration/boards.h"

namespace pavo::test {
namespace {

constexpr double kSigma_px = 0.1;

std::vector<BoardCorners> noisy_views(const Camera& camera, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<BoardCorners> views;
  for (const SE3& pose : poses(camera, count, 3)) views.push_back(corners_seen(camera, pose, kSigma_px, random));
  return views;
}

class NoisyCorners : public ::testing::TestWithParam<Camera> {};

TEST_P(NoisyCorners, ScatterTheParametersAsTheirStandardDeviationsSay) {
  constexpr int kTrials = 12;
  Camera truth = GetParam();
  const int n = parameter_count(truth.lens);
  std::vector<double> mean_square(static_cast<std::size_t>(n), 0);
  double rms = 0;
  for (unsigned trial = 0; trial < kTrials; ++trial) {
    const CalibrationResult result =
        calibrate_camera(noisy_views(truth, 8, trial), kBoard, truth.width, truth.height, truth.lens);
    Camera found = result.camera, sigma = result.sigma;
    for (int i = 0; i < n; ++i) {
      const double z = (parameter(found, i) - parameter(truth, i)) / parameter(sigma, i);
      EXPECT_LT(std::abs(z), 4.5) << "parameter " << i << ", trial " << trial;
      mean_square[static_cast<std::size_t>(i)] += z * z / kTrials;
    }
    rms += result.rms_px / kTrials;
  }
  // chi^2 with 12 degrees of freedom: 99.8 % lie within these.
  for (const double m : mean_square) EXPECT_TRUE(m > 0.17 && m < 2.8) << m;
  EXPECT_NEAR(rms, kSigma_px * std::sqrt(2), 0.01);
}

TEST_P(NoisyCorners, WithoutNoiseGiveTheCameraExactly) {
  Camera truth = GetParam();
  std::mt19937 random(0);
  std::vector<BoardCorners> views;
  for (const SE3& pose : poses(truth, 8, 4)) views.push_back(corners_seen(truth, pose, 0, random));
  Camera found = calibrate_camera(views, kBoard, truth.width, truth.height, truth.lens).camera;
  for (int i = 0; i < parameter_count(truth.lens); ++i)
    EXPECT_NEAR(parameter(found, i), parameter(truth, i), 1e-5 * std::max(1., std::abs(parameter(truth, i)))) << i;
}

INSTANTIATE_TEST_SUITE_P(Lenses, NoisyCorners, ::testing::Values(pinhole(), fisheye()),
                         [](const auto& i) { return i.param.lens == Lens::equidistant ? "Fisheye" : "Pinhole"; });

// Another implementation from end to end.
TEST(NoisyCorners, GiveTheFisheyeThatOpenCvFinds) {
  const Camera truth = fisheye();
  const std::vector<BoardCorners> views = noisy_views(truth, 12, 9);
  const CalibrationResult result = calibrate_camera(views, kBoard, truth.width, truth.height, Lens::equidistant);
  std::vector<std::vector<cv::Point3d>> points(views.size());
  std::vector<std::vector<cv::Point2d>> corners(views.size());
  for (std::size_t v = 0; v < views.size(); ++v)
    for (int i = 0; i < kBoard.corners(); ++i) {
      points[v].emplace_back(kBoard.point(i).x(), kBoard.point(i).y(), 0);
      corners[v].emplace_back(views[v][static_cast<std::size_t>(i)].x(), views[v][static_cast<std::size_t>(i)].y());
    }
  cv::Mat K, D, rotations, translations;
  const double rms = cv::fisheye::calibrate(points, corners, {truth.width, truth.height}, K, D, rotations, translations,
                                            cv::fisheye::CALIB_RECOMPUTE_EXTRINSIC | cv::fisheye::CALIB_FIX_SKEW,
                                            {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 200, 1e-12});
  EXPECT_NEAR(result.rms_px, rms, 1e-4);
  EXPECT_NEAR(result.camera.fx, K.at<double>(0, 0), 0.02);
  EXPECT_NEAR(result.camera.cy, K.at<double>(1, 2), 0.02);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(result.camera.distortion[static_cast<std::size_t>(i)], D.at<double>(i), 2e-3);
}

}  // namespace
}  // namespace pavo::test
