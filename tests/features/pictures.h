// Pictures with corners of all kinds, and a loop over the SIMD targets.
#pragma once

#include <cstring>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <vector>

#include "tests/support/simd_targets.h"
#include "types/image.h"

namespace pavo::test {

/// Rows of `width` bytes and not one more, for the sanitizer to see every read past the last one.
inline cv::Mat noise(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  cv::Mat picture(height, width, CV_8U);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) picture.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(random());
  }
  return picture;
}

/// Boxes of random size and gray on a slope, a little blurred, a little noisy: what a street looks like to a corner
/// detector.
inline cv::Mat street(int width, int height, unsigned seed, double blur = 0.8) {
  std::mt19937 random(seed);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  cv::Mat picture(height, width, CV_8U);
  for (int y = 0; y < height; ++y) picture.row(y).setTo(40 + 150 * y / height);
  for (int i = 0; i < width * height / 300; ++i) {
    const cv::Rect box(below(width) - 10, below(height) - 10, 2 + below(30), 2 + below(30));
    cv::rectangle(picture, box, below(256), cv::FILLED);
  }
  cv::GaussianBlur(picture, picture, {5, 5}, blur);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      picture.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(picture.at<std::uint8_t>(y, x) + below(5) - 2);
    }
  }
  return picture;
}

inline ImageView view(const cv::Mat& picture) {
  return {picture.data, picture.cols, picture.rows, static_cast<std::ptrdiff_t>(picture.step)};
}

inline Image image(const cv::Mat& picture) {
  Image result(picture.cols, picture.rows);
  for (int y = 0; y < picture.rows; ++y)
    std::memcpy(result.row(y), picture.ptr(y), static_cast<std::size_t>(picture.cols));
  return result;
}

/// Calls run(name) once for every SIMD target that was compiled and that this machine has, with that target in use.
template <class Run>
void on_every_target(const Run& run) {
  for (const std::int64_t target : simd_targets()) {
    const ForceTarget forced(target);
    run(std::string(hwy::TargetName(target)));
  }
}

}  // namespace pavo::test
