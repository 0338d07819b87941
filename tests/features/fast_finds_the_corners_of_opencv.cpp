#include <gtest/gtest.h>

#include <memory>
#include <opencv2/features2d.hpp>

#include "stages/features/fast.h"
#include "tests/features/pictures.h"

namespace pavo::test {
namespace {

void expect_same_corners(const cv::Mat& picture, int threshold) {
  std::vector<cv::KeyPoint> theirs;
  cv::FAST(picture, theirs, threshold, true);
  FastScratch scratch;
  const std::span<const Corner> ours = detect_fast(view(picture), threshold, scratch);
  ASSERT_EQ(ours.size(), theirs.size());
  for (std::size_t i = 0; i < ours.size(); ++i) {
    ASSERT_EQ(ours[i].x, theirs[i].pt.x);
    ASSERT_EQ(ours[i].y, theirs[i].pt.y);
    ASSERT_EQ(ours[i].score, theirs[i].response);
  }
}

TEST(FastFindsTheCornersOfOpenCV, AtAnyThreshold) {
  const cv::Mat pictures[] = {street(301, 97, 1), noise(200, 61, 2), street(160, 80, 3, 3.0)};
  on_every_target([&](const std::string& target) {
    SCOPED_TRACE(target);
    for (const cv::Mat& picture : pictures) {
      for (int threshold : {0, 1, 2, 7, 20, 60, 127, 200, 253, 254, 255}) {
        SCOPED_TRACE(threshold);
        expect_same_corners(picture, threshold);
      }
    }
  });
}

TEST(FastFindsTheCornersOfOpenCV, InAnySizeOfImage) {
  on_every_target([&](const std::string& target) {
    SCOPED_TRACE(target);
    for (int width = 7; width < 150; width += width < 80 ? 1 : 7) {
      SCOPED_TRACE(width);
      expect_same_corners(noise(width, 7 + width % 9, static_cast<unsigned>(width)), 10);
    }
  });
}

TEST(FastFindsTheCornersOfOpenCV, InAPartOfAnImage) {
  const cv::Mat whole = street(200, 100, 4);
  expect_same_corners(whole(cv::Rect(31, 17, 113, 59)), 15);
}

TEST(FastFindsTheSame, BeyondTheThresholdsThatAByteHas) {
  const cv::Mat picture = noise(60, 50, 8);
  FastScratch a, b;
  EXPECT_EQ(detect_fast(view(picture), -5, a).size(), detect_fast(view(picture), 0, b).size());
  EXPECT_TRUE(detect_fast(view(picture), 256, a).empty());
}

TEST(FastFindsNoCorners, InConstantPictures) {
  FastScratch scratch;
  for (int gray : {0, 128, 255}) {
    EXPECT_TRUE(detect_fast(view(cv::Mat(40, 90, CV_8U, cv::Scalar(gray))), 0, scratch).empty());
  }
}

TEST(FastFindsNoCorners, WhereTheCircleHasNoRoom) {
  FastScratch scratch;
  EXPECT_TRUE(detect_fast({}, 1, scratch).empty());
  for (int size = 1; size < 7; ++size) {
    EXPECT_TRUE(detect_fast(view(noise(size, 50, 1)), 1, scratch).empty());
    EXPECT_TRUE(detect_fast(view(noise(50, size, 1)), 1, scratch).empty());
  }
}

TEST(FastFindsTheSame, WithAScratchThatWasUsedForAnotherImage) {
  FastScratch used, fresh;
  detect_fast(view(noise(300, 200, 5)), 1, used);
  const cv::Mat small = street(120, 50, 6);
  const std::span<const Corner> a = detect_fast(view(small), 10, used), b = detect_fast(view(small), 10, fresh);
  EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end()));
}

/// The densest that suppression can leave: a corner in every second pixel of every second row.
TEST(FastHasRoom, ForEveryCornerThatCanBe) {
  cv::Mat picture(41, 67, CV_8U, cv::Scalar(0));
  for (int y = 0; y < picture.rows; y += 2) {
    for (int x = 0; x < picture.cols; x += 2)
      picture.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(100 + (x * 7 + y * 3) % 50);
  }
  for (int threshold : {0, 1, 10}) expect_same_corners(picture, threshold);
}

}  // namespace
}  // namespace pavo::test
