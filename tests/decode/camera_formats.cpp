// The pixel formats of cameras: luma where the format keeps it, else as a slow computation of the definition says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "stages/decode/decode.h"
#include "tests/support/simd_targets.h"

namespace pavo {
namespace {

const std::vector<int> kWidths{1, 2, 3, 16, 17, 31, 64, 65, 130, 333};

EncodedImage random_frame(Encoding encoding, int width, int height, int bytes_a_pixel, int padding) {
  std::mt19937 random(static_cast<unsigned>(width * 131 + height));
  EncodedImage frame{encoding, width, height, width * bytes_a_pixel + padding, {}};
  frame.bytes.resize(static_cast<std::size_t>(frame.stride * height));
  for (auto& byte : frame.bytes) byte = static_cast<std::uint8_t>(random());
  return frame;
}

/// On every SIMD target, `expected(frame, x, y)` within `tolerance`.
template <class Expected>
void expect_decoded(const EncodedImage& frame, double tolerance, Expected&& expected) {
  for (const std::int64_t target : test::simd_targets()) {
    const test::ForceTarget forced(target);
    Image gray;
    Decode::Scratch scratch;
    Decode(frame.width, frame.height)(frame, gray, scratch);
    for (int y = 0; y < frame.height; ++y)
      for (int x = 0; x < frame.width; ++x)
        ASSERT_NEAR(gray.at(x, y), expected(frame, x, y), tolerance)
            << x << ", " << y << " of " << frame.width << "x" << frame.height << " on " << hwy::TargetName(target);
  }
}

int byte_at(const EncodedImage& frame, int byte, int y) {
  return frame.bytes[static_cast<std::size_t>(y * frame.stride + byte)];
}

TEST(CameraFormats, KeepTheirLuma) {
  for (const int width : kWidths) {
    expect_decoded(random_frame(Encoding::yuyv, width, 3, 2, 5), 0,
                   [](const EncodedImage& f, int x, int y) { return byte_at(f, 2 * x, y); });
    expect_decoded(random_frame(Encoding::uyvy, width, 3, 2, 0), 0,
                   [](const EncodedImage& f, int x, int y) { return byte_at(f, 2 * x + 1, y); });
    expect_decoded(random_frame(Encoding::gray16, width, 3, 2, 2), 0, [](const EncodedImage& f, int x, int y) {
      return (byte_at(f, 2 * x, y) | byte_at(f, 2 * x + 1, y) << 8) >> 8;
    });
  }
}

TEST(CameraFormats, OfThreeColoursBecomeLuma) {
  for (const int width : kWidths)
    expect_decoded(random_frame(Encoding::rgb24, width, 2, 3, 1), 1, [](const EncodedImage& f, int x, int y) {
      return 0.299 * byte_at(f, 3 * x, y) + 0.587 * byte_at(f, 3 * x + 1, y) + 0.114 * byte_at(f, 3 * x + 2, y);
    });
}

struct Mosaic {
  Encoding encoding;
  std::string_view colours;  ///< of the first two pixels of row 0, then of row 1
};
constexpr Mosaic kMosaics[] = {{Encoding::bayer_bggr8, "BGGR"},
                               {Encoding::bayer_gbrg8, "GBRG"},
                               {Encoding::bayer_grbg8, "GRBG"},
                               {Encoding::bayer_rggb8, "RGGB"}};

/// The mean of those of the 3x3 neighbours that have this colour, or of the pixel itself; mirrored at the border.
double colour_at(const EncodedImage& f, const Mosaic& mosaic, char colour, int x, int y) {
  const auto colour_of = [&](int px, int py) { return mosaic.colours[static_cast<std::size_t>(py % 2 * 2 + px % 2)]; };
  if (colour_of(x, y) == colour) return byte_at(f, x, y);
  const auto mirrored = [](int i, int n) { return i < 0 ? -i : i >= n ? 2 * (n - 1) - i : i; };
  double sum = 0, count = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const int px = mirrored(x + dx, f.width), py = mirrored(y + dy, f.height);
      if (colour_of(px, py) != colour) continue;
      sum += byte_at(f, px, py);
      ++count;
    }
  return sum / count;
}

TEST(CameraFormats, BayerMosaicsBecomeTheLumaOfTheirInterpolation) {
  for (const Mosaic& mosaic : kMosaics)
    for (const int width : {2, 3, 17, 64, 65, 130})
      for (const int height : {2, 5})
        expect_decoded(random_frame(mosaic.encoding, width, height, 1, 3), 3.0,
                       [&](const EncodedImage& f, int x, int y) {
                         return 0.299 * colour_at(f, mosaic, 'R', x, y) + 0.587 * colour_at(f, mosaic, 'G', x, y) +
                                0.114 * colour_at(f, mosaic, 'B', x, y);
                       });
}

// OpenCV names a mosaic by the second pixel of its second row: its BayerRG is RGGB's BGGR.
TEST(CameraFormats, BayerMosaicsAgreeWithOpenCVWithinTheBorder) {
  const EncodedImage frame = random_frame(Encoding::bayer_rggb8, 130, 40, 1, 0);
  const cv::Mat mosaic(frame.height, frame.width, CV_8U, const_cast<std::uint8_t*>(frame.bytes.data()));
  cv::Mat expected;
  cv::cvtColor(mosaic, expected, cv::COLOR_BayerBG2GRAY);
  Image gray;
  Decode::Scratch scratch;
  Decode()(frame, gray, scratch);
  for (int y = 1; y + 1 < frame.height; ++y)
    for (int x = 1; x + 1 < frame.width; ++x)
      ASSERT_NEAR(gray.at(x, y), expected.at<std::uint8_t>(y, x), 3) << x << ", " << y;
}

TEST(CameraFormats, OfOneGrayAreThatGray) {
  for (const Mosaic& mosaic : kMosaics)
    for (const int level : {0, 1, 127, 255}) {
      EncodedImage frame = random_frame(mosaic.encoding, 67, 9, 1, 0);
      std::fill(frame.bytes.begin(), frame.bytes.end(), static_cast<std::uint8_t>(level));
      expect_decoded(frame, 0, [&](const EncodedImage&, int, int) { return level; });
    }
}

TEST(CameraFormats, ThatAreCutOffAreErrors) {
  Decode::Scratch scratch;
  Image gray;
  for (const Encoding encoding : {Encoding::yuyv, Encoding::uyvy, Encoding::gray16, Encoding::rgb24,
                                  Encoding::bayer_bggr8, Encoding::bayer_rggb8}) {
    EncodedImage frame = random_frame(encoding, 16, 4, encoding == Encoding::rgb24 ? 3 : 2, 0);
    EXPECT_NO_THROW(Decode()(frame, gray, scratch));
    frame.bytes.resize(frame.bytes.size() / 4);
    EXPECT_THROW(Decode()(frame, gray, scratch), std::runtime_error);
    frame.bytes.clear();
    EXPECT_THROW(Decode()(frame, gray, scratch), std::runtime_error);
  }
}

}  // namespace
}  // namespace pavo
