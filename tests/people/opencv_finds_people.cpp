#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "stages/decode/decode.h"
#include "stages/people/scan_opencv.h"
#include "tests/support/data.h"

namespace pavo {
namespace {

Image from_mat(const cv::Mat& gray) {
  Image image(gray.cols, gray.rows);
  for (int y = 0; y < gray.rows; ++y) std::copy_n(gray.ptr(y), gray.cols, image.row(y));
  return image;
}

TEST(ScanOpencv, FindsThePersonOfATrainingCrop) {
  PAVO_NEEDS_DATA("people/train/positive");
  const auto file = pavo::test::data_folder() / "people/train/positive/crop001001a.png";
  cv::setNumThreads(1);
  EncodedImage encoded;
  std::ifstream in(file, std::ios::binary);
  encoded.bytes.assign(std::istreambuf_iterator<char>(in), {});
  Image crop;
  Decode::Scratch decoding;
  Decode{}(encoded, crop, decoding);
  cv::Mat gray(crop.height(), crop.width(), CV_8U, crop.row(0), static_cast<std::size_t>(crop.stride()));
  cv::Mat larger;
  cv::resize(gray, larger, {}, 1.5, 1.5);
  Detections found;
  ScanPeopleOpencv::Scratch scratch;
  ScanPeopleOpencv{}(from_mat(larger), found, scratch);
  ASSERT_FALSE(found.empty());
  EXPECT_NEAR(found[0].x + found[0].width / 2, 52, 12);
  EXPECT_NEAR(found[0].y + found[0].height / 2, 100, 18);
  EXPECT_NEAR(found[0].height, 1.5 * 96, 25);
}

TEST(ScanOpencv, NothingInSmallOrEmptyImages) {
  ScanPeopleOpencv::Scratch scratch;
  for (auto [w, h] : {std::pair(0, 0), {1, 1}, {63, 400}, {400, 127}}) {
    Detections found{{1, 2, 3, 4, 5}};
    ScanPeopleOpencv{}(Image(w, h), found, scratch);
    EXPECT_TRUE(found.empty()) << w << "x" << h;
  }
  Detections found;
  ScanPeopleOpencv{}(Image(64, 128), found, scratch);
  EXPECT_TRUE(found.empty()) << "a constant image";
}

TEST(ScanOpencv, RefusesOptionsOutOfRange) {
  ScanOpencvOptions stride;
  stride.stride_px = 4;
  EXPECT_THROW(ScanPeopleOpencv{stride}, std::invalid_argument);
  ScanOpencvOptions scale;
  scale.scale_step = 1;
  EXPECT_THROW(ScanPeopleOpencv{scale}, std::invalid_argument);
}

}  // namespace
}  // namespace pavo
