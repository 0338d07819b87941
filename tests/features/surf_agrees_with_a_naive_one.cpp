#include <gtest/gtest.h>

#include <numbers>
#include <numeric>

#include "stages/features/fast.h"
#include "stages/features/surf.h"
#include "tests/features/naive_surf.h"
#include "tests/features/pictures.h"

namespace pavo::test {
namespace {

Features corners_of(const cv::Mat& picture, std::size_t most) {
  FastScratch scratch;
  Features features;
  const std::span<const Corner> corners = detect_fast(view(picture), 20, scratch);
  const std::size_t step = std::max<std::size_t>(1, corners.size() / most);
  for (std::size_t i = 0; i < corners.size(); i += step) {
    features.keypoints.push_back({static_cast<float>(corners[i].x), static_cast<float>(corners[i].y), 0, 0});
  }
  features.reserve(features.size());
  return features;
}

double cosine(const float* a, const std::array<double, 64>& b) {
  return std::inner_product(b.begin(), b.end(), a, 0.0);
}

double degrees_apart(double a, double b) {
  const double apart = std::abs(std::remainder(a - b, 2 * std::numbers::pi));
  return apart * 180 / std::numbers::pi;
}

/// Keypoints near the border are among them: there the naive one repeats the border too.
TEST(SurfAgreesWithANaiveOne, Upright) {
  const cv::Mat picture = street(190, 130, 1);
  for (double size : {9.0, 11.0, 14.5, 15.0, 17.0, 20.0, 21.0}) {
    SCOPED_TRACE(size);
    const NaiveSurf naive(view(picture), size);
    Features features = corners_of(picture, 40);
    Surf::Scratch scratch;
    Surf{size, false}(view(picture), features, scratch);
    for (std::size_t i = 0; i < features.size(); ++i) {
      const Keypoint& k = features.keypoints[i];
      EXPECT_GT(cosine(features.descriptor(i), naive.upright(k.x, k.y)), 0.999) << k.x << ", " << k.y;
      EXPECT_EQ(k.angle_rad, 0);
    }
  }
}

TEST(SurfAgreesWithANaiveOne, Oriented) {
  const cv::Mat picture = street(190, 130, 2);
  for (double size : {9.0, 14.0, 20.0}) {
    SCOPED_TRACE(size);
    const NaiveSurf naive(view(picture), size);
    Features features = corners_of(picture, 40);
    Surf::Scratch scratch;
    Surf{size, true}(view(picture), features, scratch);
    int same_direction = 0;
    for (std::size_t i = 0; i < features.size(); ++i) {
      const Keypoint& k = features.keypoints[i];
      EXPECT_GT(cosine(features.descriptor(i), naive.oriented(k.x, k.y, k.angle_rad)), 0.999) << k.x << ", " << k.y;
      same_direction += degrees_apart(k.angle_rad, naive.angle(k.x, k.y)) < 0.1;
    }
    // Where two windows are as long, or a gradient lies between two degrees, rounding decides.
    EXPECT_GE(same_direction, static_cast<int>(features.size() * 95 / 100));
  }
}

TEST(SurfDescriptors, HaveUnitLength) {
  const cv::Mat picture = street(190, 130, 3);
  for (bool oriented : {false, true}) {
    Features features = corners_of(picture, 60);
    Surf::Scratch scratch;
    Surf{9, oriented}(view(picture), features, scratch);
    for (std::size_t i = 0; i < features.size(); ++i) {
      const float* d = features.descriptor(i);
      EXPECT_NEAR(std::inner_product(d, d + 64, d, 0.0), 1, 1e-5);
    }
  }
}

TEST(SurfDescriptors, AreZeroWhereThereIsNoGradient) {
  const cv::Mat picture(60, 60, CV_8U, cv::Scalar(77));
  for (bool oriented : {false, true}) {
    Features features;
    features.reserve(1);
    features.keypoints.push_back({30, 30, 0, 0});
    Surf::Scratch scratch;
    Surf{9, oriented}(view(picture), features, scratch);
    for (int i = 0; i < 64; ++i) EXPECT_EQ(features.descriptor(0)[i], 0);
  }
}

/// A part of an image gives the same bits as the whole one, if no keypoint is nearer to its border than the support.
TEST(SurfDescriptors, DependOnNothingBeyondTheSupport) {
  const cv::Mat whole = street(150, 120, 4);
  for (double size : {9.0, 20.0}) {
    for (bool oriented : {false, true}) {
      const Surf surf(size, oriented);
      Surf::Scratch scratch;
      const int reach = surf.support();
      const cv::Mat part = whole(cv::Rect(70 - reach, 60 - reach, 2 * reach + 1, 2 * reach + 1)).clone();
      Features in_whole, in_part;
      in_whole.reserve(1);
      in_part.reserve(1);
      in_whole.keypoints.push_back({70, 60, 0, 0});
      in_part.keypoints.push_back({static_cast<float>(reach), static_cast<float>(reach), 0, 0});
      surf(view(whole), in_whole, scratch);
      surf(view(part), in_part, scratch);
      EXPECT_EQ(in_whole.keypoints[0].angle_rad, in_part.keypoints[0].angle_rad);
      EXPECT_TRUE(std::equal(in_whole.descriptor(0), in_whole.descriptor(0) + 64, in_part.descriptor(0)))
          << size << (oriented ? " oriented" : " upright");
    }
  }
}

TEST(Surf, RefusesSizesThatItHasNoTablesFor) {
  for (double size : {0.0, -9.0, 8.9, 21.1, 1e9, std::nan("")}) EXPECT_THROW(Surf(size, false), std::runtime_error);
}

}  // namespace
}  // namespace pavo::test
