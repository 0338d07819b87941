#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <opencv2/imgproc.hpp>

#include "tests/decode/files.h"
#include "tests/support/data.h"
#include "tests/support/simd_targets.h"

namespace pavo::test {
namespace {

void expect_agreement(const Bytes& bytes, const std::string& what, int limit = 1) {
  const cv::Mat expected = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
  ASSERT_FALSE(expected.empty()) << what;
  EXPECT_LE(largest_difference(decode(file_of(bytes)), expected), limit) << what;
}

TEST(DecodeAndImread, AgreeOnJpeg) {
  for (const int type : {CV_8UC1, CV_8UC3})
    for (const auto& [width, height] : {std::pair(160, 120), std::pair(1, 1), std::pair(17, 9), std::pair(123, 77)})
      for (const int quality : {30, 92, 100})
        for (const int progressive : {0, 1})
          expect_agreement(encode(".jpg", picture(width, height, type),
                                  {cv::IMWRITE_JPEG_QUALITY, quality, cv::IMWRITE_JPEG_PROGRESSIVE, progressive}),
                           std::to_string(width) + "x" + std::to_string(height) + " at " + std::to_string(quality));
}

TEST(DecodeAndImread, AgreeOnEveryOtherFormat) {
  for (const char* extension : {".png", ".bmp", ".tiff", ".pgm", ".ppm"})
    for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1, CV_16UC3, CV_8UC4}) {
      const std::string format = extension;
      if (CV_MAT_DEPTH(type) == CV_16U && format == ".bmp") continue;
      if ((format == ".pgm") != (CV_MAT_CN(type) == 1) && (format == ".pgm" || format == ".ppm")) continue;
      if (CV_MAT_CN(type) == 4 && format != ".png" && format != ".bmp") continue;
      for (const auto& [width, height] : {std::pair(64, 48), std::pair(1, 1), std::pair(33, 7)})
        expect_agreement(encode(extension, picture(width, height, type)), format + " of type " + std::to_string(type));
    }
}

TEST(DecodeAndImread, AgreeOnAsciiAndBilevel) {
  expect_agreement(encode(".pgm", picture(13, 11, CV_8UC1), {cv::IMWRITE_PXM_BINARY, 0}), "P2");
  expect_agreement(encode(".ppm", picture(13, 11, CV_8UC3), {cv::IMWRITE_PXM_BINARY, 0}), "P3");
  expect_agreement(encode(".png", picture(13, 11, CV_8UC1), {cv::IMWRITE_PNG_BILEVEL, 1}), "1-bit PNG");
}

TEST(DecodeAndImread, AgreeOnARealFrame) {
  PAVO_NEEDS_DATA("sequences/kitti-city-134/image_2");
  const auto folder = data_folder() / "sequences" / "kitti-city-134" / "image_2";
  const auto path = std::filesystem::directory_iterator(folder)->path();
  std::ifstream file(path, std::ios::binary);
  expect_agreement(Bytes(std::istreambuf_iterator<char>(file), {}), path.string());
}

/// Of 16 bits the upper 8 are kept.
TEST(Decode, SixteenBitsBecomeTheUpperEight) {
  cv::Mat wide(1, 4, CV_16UC1);
  const std::uint16_t values[] = {0x00FF, 0x0100, 0xFEFF, 0xFFFF};
  for (int x = 0; x < 4; ++x) wide.at<std::uint16_t>(0, x) = values[x];
  for (const char* extension : {".png", ".tiff", ".pgm"}) {
    const Image image = decode(file_of(encode(extension, wide)));
    EXPECT_EQ(image.at(0, 0), 0) << extension;
    EXPECT_EQ(image.at(1, 0), 1) << extension;
    EXPECT_EQ(image.at(2, 0), 0xFE) << extension;
    EXPECT_EQ(image.at(3, 0), 0xFF) << extension;
  }
}

TEST(Decode, SmallRangesOfPgmAreSpread) {
  const std::string text = "P2 # a comment\n3 1\n# another\n15\n0 5 15\n";
  const Image image = decode(file_of(Bytes(text.begin(), text.end())));
  EXPECT_EQ(image.at(0, 0), 0);
  EXPECT_EQ(image.at(1, 0), 85);
  EXPECT_EQ(image.at(2, 0), 255);
}

TEST(DecodeUncompressed, GrayIsCopied) {
  EncodedImage frame{Encoding::gray8, 5, 3, 7, Bytes(7 * 2 + 5)};
  for (std::size_t i = 0; i < frame.bytes.size(); ++i) frame.bytes[i] = static_cast<std::uint8_t>(i * 11);
  const Image image = decode(frame);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 5; ++x) EXPECT_EQ(image.at(x, y), frame.bytes[static_cast<std::size_t>(y * 7 + x)]);
}

TEST(DecodeUncompressed, ColourAgreesWithCvtColorOnEveryTarget) {
  for (const std::int64_t target : simd_targets()) {
    const ForceTarget force(target);
    for (const int width : {1, 15, 16, 63, 64, 65, 200}) {
      const cv::Mat colour = picture(width, 9, CV_8UC3);
      cv::Mat expected;
      cv::cvtColor(colour, expected, cv::COLOR_BGR2GRAY);
      const EncodedImage frame{Encoding::bgr24, width, 9, width * 3, Bytes(colour.datastart, colour.dataend)};
      EXPECT_LE(largest_difference(decode(frame), expected), 1) << width << " on " << hwy::TargetName(target);
    }
  }
}

TEST(DecodeUncompressed, WhiteAndBlackStayWhatTheyAre) {
  for (const int value : {0, 255}) {
    const EncodedImage frame{Encoding::bgr24, 100, 2, 300, Bytes(600, static_cast<std::uint8_t>(value))};
    const Image image = decode(frame);
    for (int x = 0; x < 100; ++x) EXPECT_EQ(image.at(x, 1), value);
  }
}

}  // namespace
}  // namespace pavo::test
