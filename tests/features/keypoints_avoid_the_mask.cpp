#include <gtest/gtest.h>

#include "stages/features/extract.h"
#include "tests/features/pictures.h"

namespace pavo::test {
namespace {

/// What undistortion leaves: a border that is curved, and a speck.
cv::Mat lens_mask(int width, int height) {
  cv::Mat mask(height, width, CV_8U, cv::Scalar(0));
  cv::ellipse(mask, {width / 2, height / 2}, {width / 2, height / 2 + 10}, 0, 0, 360, 255, cv::FILLED);
  mask.at<std::uint8_t>(height / 2, width / 2) = 0;
  return mask;
}

class KeypointsAvoidTheMask : public testing::TestWithParam<FeatureOptions> {};

TEST_P(KeypointsAvoidTheMask, AndTheBorder) {
  const cv::Mat picture = street(260, 180, 1), mask = lens_mask(260, 180);
  const ExtractFeatures extract(GetParam(), 260, 180, view(mask));
  ExtractFeatures::Scratch scratch;
  Features features;
  extract(image(picture), features, scratch);
  ASSERT_GT(features.size(), 50u);
  const int m = extract.margin();
  for (const Keypoint& k : features.keypoints) {
    const cv::Rect support(static_cast<int>(k.x) - m, static_cast<int>(k.y) - m, 2 * m + 1, 2 * m + 1);
    ASSERT_EQ(support & cv::Rect(0, 0, 260, 180), support);
    EXPECT_EQ(cv::countNonZero(mask(support)), support.area()) << k.x << ", " << k.y;
  }
}

/// The proof by trying: whatever stands in the masked pixels, keypoints that are kept keep their descriptors.
TEST_P(KeypointsAvoidTheMask, SoThatItsPixelsDoNotMatter) {
  cv::Mat picture = street(260, 180, 2);
  const cv::Mat mask = lens_mask(260, 180);
  const ExtractFeatures extract(GetParam(), 260, 180, view(mask));
  ExtractFeatures::Scratch scratch;
  Features before, after;
  extract(image(picture), before, scratch);
  noise(260, 180, 3).copyTo(picture, mask == 0);
  extract(image(picture), after, scratch);
  // Suppression looks one pixel farther than the circle: a keypoint at the edge may come or go. None may change.
  std::size_t same = 0;
  for (std::size_t i = 0, j = 0; i < before.size() && j < after.size();) {
    const Keypoint &a = before.keypoints[i], &b = after.keypoints[j];
    if (a.x == b.x && a.y == b.y) {
      EXPECT_EQ(a.response, b.response);
      EXPECT_EQ(a.angle_rad, b.angle_rad);
      if (GetParam().descriptors) {
        EXPECT_TRUE(std::equal(before.descriptor(i), before.descriptor(i) + 64, after.descriptor(j)));
      }
      ++same, ++i, ++j;
    } else {
      std::pair(a.y, a.x) < std::pair(b.y, b.x) ? ++i : ++j;
    }
  }
  EXPECT_GE(same + 10, before.size());
}

INSTANTIATE_TEST_SUITE_P(OfEveryKind, KeypointsAvoidTheMask,
                         testing::Values(FeatureOptions{.descriptors = false}, FeatureOptions{},
                                         FeatureOptions{.oriented = true},
                                         FeatureOptions{.oriented = false, .keypoint_size = 20}));

TEST(AMaskThatExcludesEverything, LeavesNoKeypoint) {
  const cv::Mat mask(80, 120, CV_8U, cv::Scalar(0));
  const ExtractFeatures extract({}, 120, 80, view(mask));
  ExtractFeatures::Scratch scratch;
  Features features;
  extract(image(street(120, 80, 1)), features, scratch);
  EXPECT_EQ(features.size(), 0u);
}

TEST(AMaskThatExcludesNothing, ChangesNothing) {
  const cv::Mat mask(80, 120, CV_8U, cv::Scalar(255));
  const Image picture = image(street(120, 80, 1));
  ExtractFeatures::Scratch scratch;
  Features with, without;
  ExtractFeatures({}, 120, 80, view(mask))(picture, with, scratch);
  ExtractFeatures({}, 120, 80)(picture, without, scratch);
  ASSERT_GT(with.size(), 10u);
  ASSERT_EQ(with.size(), without.size());
  EXPECT_TRUE(std::equal(with.descriptor(0), with.descriptor(with.size()), without.descriptor(0)));
}

}  // namespace
}  // namespace pavo::test
