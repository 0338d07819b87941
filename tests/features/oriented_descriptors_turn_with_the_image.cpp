#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <numeric>

#include "stages/features/surf.h"
#include "tests/features/pictures.h"

namespace pavo::test {
namespace {

struct Described {
  Keypoint keypoint;
  std::vector<float> descriptor;
};

Described describe(const cv::Mat& picture, float x, float y, bool oriented) {
  Features features;
  features.reserve(1);
  features.keypoints.push_back({x, y, 0, 0});
  Surf::Scratch scratch;
  Surf{9, oriented}(view(picture), features, scratch);
  return {features.keypoints[0], {features.descriptor(0), features.descriptor(0) + 64}};
}

double cosine(const Described& a, const Described& b) {
  return std::inner_product(a.descriptor.begin(), a.descriptor.end(), b.descriptor.begin(), 0.0);
}

/// Turned about its middle, clockwise as one looks at it.
cv::Mat turned(const cv::Mat& picture, double degrees) {
  const cv::Point2f middle(static_cast<float>(picture.cols / 2), static_cast<float>(picture.rows / 2));
  cv::Mat result;
  cv::warpAffine(picture, result, cv::getRotationMatrix2D(middle, -degrees, 1), picture.size(), cv::INTER_CUBIC);
  return result;
}

/// The orientation is sampled coarsely, so that a single patch may turn by some degrees more or less: the median
/// counts.
TEST(OrientedDescriptors, StayTheSameWhenTheImageTurns) {
  for (double degrees : {20.0, 45.0, 90.0, 133.0, 180.0, 260.0}) {
    SCOPED_TRACE(degrees);
    std::vector<double> errors, cosines;
    for (unsigned seed = 1; seed <= 25; ++seed) {
      const cv::Mat picture = street(91, 91, seed, 2.0);
      const Described straight = describe(picture, 45, 45, true);
      const Described other = describe(turned(picture, degrees), 45, 45, true);
      const double turn = other.keypoint.angle_rad - straight.keypoint.angle_rad - degrees * std::numbers::pi / 180;
      errors.push_back(std::abs(std::remainder(turn, 2 * std::numbers::pi)));
      cosines.push_back(cosine(straight, other));
    }
    std::sort(errors.begin(), errors.end());
    std::sort(cosines.begin(), cosines.end());
    EXPECT_LT(errors[12], 0.15);
    EXPECT_GT(cosines[12], 0.9);
    EXPECT_GT(cosines[5], 0.8);
  }
}

TEST(UprightDescriptors, ChangeWhenTheImageTurns) {
  const cv::Mat picture = street(121, 121, 1, 2.0);
  EXPECT_LT(cosine(describe(picture, 60, 60, false), describe(turned(picture, 90), 60, 60, false)), 0.8);
}

/// gray = slope * (x cos a + y sin a): the gradient points to a, which is what the paper calls the dominant
/// orientation.
TEST(OrientedDescriptors, PointAlongTheGradient) {
  for (double angle = -3; angle < 3.1; angle += 0.5) {
    cv::Mat picture(81, 81, CV_8U);
    for (int y = 0; y < 81; ++y) {
      for (int x = 0; x < 81; ++x) {
        const double along = (x - 40) * std::cos(angle) + (y - 40) * std::sin(angle);
        picture.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(128 + 2 * along);
      }
    }
    const Described found = describe(picture, 40, 40, true);
    EXPECT_NEAR(found.keypoint.angle_rad, angle, 0.03);
    // All of it runs along the direction: (dx, dy, |dx|, |dy|) = (+, 0, +, 0) in the middle's cells.
    EXPECT_GT(found.descriptor[4 * 5], 0.2);
    EXPECT_NEAR(found.descriptor[4 * 5 + 1], 0, 0.03);
  }
}

}  // namespace
}  // namespace pavo::test
