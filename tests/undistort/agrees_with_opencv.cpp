#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "stages/undistort/undistort.h"
#include "tests/support/simd_targets.h"
#include "tests/undistort/cameras.h"
#include "types/lens.h"

namespace pavo::test {
namespace {

cv::Matx33d matrix_of(const Camera& c) {
  return {c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1};
}

cv::Mat mat_of(const Image& image) {
  return cv::Mat(image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.row(0)),
                 static_cast<std::size_t>(image.stride()));
}

/// OpenCV's map in float, which its remap rounds to 1/32 pixel.
void opencv_maps(const Camera& from, const Camera& to, cv::Mat& x, cv::Mat& y) {
  const cv::Size size(from.width, from.height);
  const auto& k = from.distortion;
  if (from.lens == Lens::equidistant) {
    const cv::Vec4d d(k[0], k[1], k[2], k[3]);
    cv::fisheye::initUndistortRectifyMap(matrix_of(from), d, cv::Matx33d::eye(), matrix_of(to), size, CV_32FC1, x, y);
  } else {
    const cv::Mat d(1, 8, CV_64F, const_cast<double*>(k.data()));
    cv::initUndistortRectifyMap(matrix_of(from), d, cv::noArray(), matrix_of(to), size, CV_32FC1, x, y);
  }
}

/// Bilinear interpolation in double.
double sample(const Image& image, double x, double y) {
  const int x0 = std::min(static_cast<int>(x), image.width() - 2),
            y0 = std::min(static_cast<int>(y), image.height() - 2);
  const double fx = x - x0, fy = y - y0;
  const double upper = (1 - fx) * image.at(x0, y0) + fx * image.at(x0 + 1, y0);
  const double lower = (1 - fx) * image.at(x0, y0 + 1) + fx * image.at(x0 + 1, y0 + 1);
  return (1 - fy) * upper + fy * lower;
}

struct Difference {
  double largest = 0;
  int counted = 0;
  void add(double d) {
    largest = std::max(largest, std::abs(d));
    ++counted;
  }
};

TEST(UndistortAndOpenCv, ShowTheSamePicture) {
  for (const auto& [name, camera] : cameras())
    for (const double alpha : {0.0, 0.6}) {
      const Undistort undistort(camera, alpha);
      const Image raw = picture(camera.width, camera.height);
      Image image;
      undistort(raw, image);
      cv::Mat map_x, map_y, expected;
      opencv_maps(camera, undistort.rectified_camera(), map_x, map_y);
      cv::remap(mat_of(raw), expected, map_x, map_y, cv::INTER_LINEAR);
      Difference difference;
      for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
          if (undistort.valid_mask().at(x, y)) difference.add(image.at(x, y) - expected.at<std::uint8_t>(y, x));
      EXPECT_LE(difference.largest, 2) << name << ", alpha " << alpha;
      EXPECT_GT(difference.counted, camera.width * camera.height / 2) << name << ", alpha " << alpha;
    }
}

/// Rounding to 1/128 pixel moves noise by at most 255 / 128 in x and in y, half of that for the middle of the step.
TEST(UndistortAndOpenCv, AgreesWithInterpolationInDoubleOnNoise) {
  for (const std::int64_t target : simd_targets()) {
    const ForceTarget force(target);
    for (const auto& [name, camera] : cameras()) {
      const Undistort undistort(camera);
      const Image raw = noise(camera.width, camera.height, 1);
      Image image;
      undistort(raw, image);
      cv::Mat map_x, map_y;
      opencv_maps(camera, undistort.rectified_camera(), map_x, map_y);
      Difference difference;
      for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
          const auto u = static_cast<double>(map_x.at<float>(y, x)), v = static_cast<double>(map_y.at<float>(y, x));
          if (!undistort.valid_mask().at(x, y) || u < 0 || v < 0 || v > camera.height - 2) continue;
          difference.add(image.at(x, y) - sample(raw, u, v));
        }
      EXPECT_LE(difference.largest, 3) << name << " on " << hwy::TargetName(target);
    }
  }
}

TEST(UndistortAndOpenCv, WidenTheViewAlike) {
  for (const auto& [name, camera] : cameras()) {
    if (camera.lens == Lens::equidistant) continue;  // OpenCV has another rule there
    const cv::Mat d(1, 8, CV_64F, const_cast<double*>(camera.distortion.data()));
    const cv::Size size(camera.width, camera.height);
    const cv::Matx33d wide = cv::getOptimalNewCameraMatrix(matrix_of(camera), d, size, 1, size);
    const Camera ours = widened_camera(camera, 1);
    // OpenCV looks at 9 points of each side, we at all of them.
    EXPECT_NEAR(ours.fx, wide(0, 0), 0.02 * wide(0, 0)) << name;
    EXPECT_NEAR(ours.fy, wide(1, 1), 0.02 * wide(1, 1)) << name;
    EXPECT_NEAR(ours.cx, wide(0, 2), 0.02 * camera.width) << name;
    EXPECT_NEAR(ours.cy, wide(1, 2), 0.02 * camera.height) << name;
  }
}

TEST(LensAndOpenCv, ProjectAlike) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> side(-0.6, 0.6);
  for (const auto& [name, camera] : cameras())
    for (int n = 0; n < 50; ++n) {
      const Eigen::Vector3d point(side(random), side(random), 1);
      std::vector<cv::Point2d> pixel;
      const auto& k = camera.distortion;
      if (camera.lens == Lens::equidistant)
        cv::fisheye::projectPoints(std::vector<cv::Point3d>{{point.x(), point.y(), point.z()}}, pixel, cv::Vec3d(),
                                   cv::Vec3d(), matrix_of(camera), cv::Vec4d(k[0], k[1], k[2], k[3]));
      else
        cv::projectPoints(std::vector<cv::Point3d>{{point.x(), point.y(), point.z()}}, cv::Vec3d(), cv::Vec3d(),
                          matrix_of(camera), cv::Mat(1, 8, CV_64F, const_cast<double*>(k.data())), pixel);
      const Eigen::Vector2d ours = project(camera, point);
      EXPECT_NEAR(ours.x(), pixel[0].x, 1e-6) << name;
      EXPECT_NEAR(ours.y(), pixel[0].y, 1e-6) << name;
    }
}

}  // namespace
}  // namespace pavo::test
