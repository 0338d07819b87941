#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "stages/features/extract.h"
#include "tests/features/pictures.h"

namespace pavo::test {
namespace {

using testing::HasSubstr;

std::string error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

std::string error_of(const FeatureOptions& options) {
  return error_of([&] { ExtractFeatures(options, 100, 80); });
}

TEST(FeaturesRefuse, OptionsOutOfTheirRange) {
  EXPECT_EQ(error_of(FeatureOptions{.max_features = 0}), "features: max_features = 0: expected 1 to 65535");
  EXPECT_EQ(error_of(FeatureOptions{.cell_px = 7}), "features: cell_px = 7: expected 8 to 255");
  EXPECT_EQ(error_of(FeatureOptions{.min_score = 255}), "features: min_score = 255: expected 1 to 254");
  EXPECT_EQ(error_of(FeatureOptions{.keypoint_size = 8.5}), "features: keypoint_size = 8.5: expected 9 to 21");
  EXPECT_THAT(error_of(FeatureOptions{.keypoint_size = std::nan("")}), HasSubstr("expected 9 to 21"));
  EXPECT_EQ(error_of(FeatureOptions{}), "no error");
}

TEST(FeaturesRefuse, AMaskOfAnotherSize) {
  const cv::Mat mask(80, 101, CV_8U, cv::Scalar(255));
  EXPECT_EQ(error_of([&] { ExtractFeatures({}, 100, 80, view(mask)); }),
            "features: the mask is 101x80: expected the images' 100x80");
}

TEST(FeaturesRefuse, AnImageOfAnotherSize) {
  const ExtractFeatures extract({}, 100, 80);
  ExtractFeatures::Scratch scratch;
  Features features;
  EXPECT_EQ(error_of([&] { extract(image(street(100, 81, 1)), features, scratch); }),
            "features: the image is 100x81: expected 100x80 as all of this run");
}

}  // namespace
}  // namespace pavo::test
