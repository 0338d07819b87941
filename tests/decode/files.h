// Image files made by OpenCV, and what OpenCV reads from them.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "stages/decode/decode.h"

namespace pavo::test {

using Bytes = std::vector<std::uint8_t>;

inline EncodedImage file_of(std::span<const std::uint8_t> bytes) {
  EncodedImage encoded;
  encoded.bytes.assign(bytes.begin(), bytes.end());
  return encoded;
}

/// A colourful picture with texture; `type` is CV_8UC1, CV_8UC3, CV_16UC1, ...
inline cv::Mat picture(int width, int height, int type) {
  cv::Mat image(height, width, CV_64FC(CV_MAT_CN(type)));
  const double scale = CV_MAT_DEPTH(type) == CV_16U ? 257 : 1;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < image.channels(); ++c)
        image.ptr<double>(y)[x * image.channels() + c] =
            scale *
            (127 + 60 * std::sin(0.2 * x + c) + 50 * std::cos(0.15 * y - 2 * c) + (x * 7 + y * 13 + c * 5) % 17);
  cv::Mat converted;
  image.convertTo(converted, CV_MAT_DEPTH(type));
  return converted;
}

inline Bytes encode(const std::string& extension, const cv::Mat& image, const std::vector<int>& parameters = {}) {
  Bytes bytes;
  EXPECT_TRUE(cv::imencode(extension, image, bytes, parameters)) << extension;
  return bytes;
}

inline Image decode(const EncodedImage& encoded, int expected_width = 0, int expected_height = 0) {
  Decode::Scratch scratch;
  Image image;
  Decode(expected_width, expected_height)(encoded, image, scratch);
  return image;
}

inline int largest_difference(const Image& image, const cv::Mat& expected) {
  if (image.width() != expected.cols || image.height() != expected.rows) return 1000;
  int largest = 0;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      largest = std::max(largest, std::abs(int{image.at(x, y)} - int{expected.at<std::uint8_t>(y, x)}));
  return largest;
}

/// The error's message, or "" when there was none.
inline std::string error_of(const EncodedImage& encoded, int expected_width = 0, int expected_height = 0) {
  try {
    decode(encoded, expected_width, expected_height);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

}  // namespace pavo::test
