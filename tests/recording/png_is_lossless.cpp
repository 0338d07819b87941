// Whatever is in an image, its PNG decodes to the same pixels, by our own decoder and by OpenCV's.
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <random>

#include "drivers/recording/encode_png.h"
#include "stages/decode/decode.h"

namespace pavo {
namespace {

void expect_same(const Image& image, const std::vector<std::uint8_t>& png) {
  const cv::Mat theirs = cv::imdecode(png, cv::IMREAD_UNCHANGED);
  ASSERT_EQ(theirs.type(), CV_8UC1);
  ASSERT_EQ(theirs.size(), cv::Size(image.width(), image.height()));
  EncodedImage encoded{.bytes = png};
  Decode::Scratch scratch;
  Image ours;
  Decode{}(encoded, ours, scratch);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      ASSERT_EQ(ours.at(x, y), image.at(x, y)) << x << ' ' << y;
      ASSERT_EQ(theirs.at<std::uint8_t>(y, x), image.at(x, y)) << x << ' ' << y;
    }
}

TEST(Png, DecodesToTheSamePixels) {
  std::mt19937 random(1);
  EncodePng encode;
  std::vector<std::uint8_t> png;
  for (const auto& [width, height] : {std::pair(1, 1), {1, 50}, {50, 1}, {7, 5}, {64, 48}, {641, 33}}) {
    for (const int kind : {0, 1, 2, 3}) {
      Image image(width, height);
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
          image.at(x, y) = static_cast<std::uint8_t>(kind == 0   ? 0
                                                     : kind == 1 ? 255
                                                     : kind == 2 ? 3 * x + 5 * y
                                                                 : random());
      encode(image.view(), png);
      expect_same(image, png);
    }
  }
}

TEST(Png, IsSmallerThanThePixelsWhereTheyAreSmooth) {
  Image image(640, 480);
  std::mt19937 random(2);
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) image.at(x, y) = static_cast<std::uint8_t>(x / 4 + y / 5 + random() % 4);
  EncodePng encode;
  std::vector<std::uint8_t> png;
  encode(image.view(), png);
  EXPECT_LT(png.size(), 640u * 480u / 2);
}

TEST(Png, OfNothingIsRefused) {
  std::vector<std::uint8_t> png;
  EXPECT_THROW(EncodePng{}(ImageView{}, png), std::invalid_argument);
}

}  // namespace
}  // namespace pavo
