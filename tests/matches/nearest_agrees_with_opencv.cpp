#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <opencv2/features2d.hpp>
#include <sstream>
#include <utility>
#include <vector>

#include "stages/matches/nearest.h"
#include "tests/matches/random_features.h"
#include "tests/support/data.h"

namespace pavo::test {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

cv::Mat as_mat(const Features& f) {
  return cv::Mat(static_cast<int>(f.size()), Features::kDescriptorSize, CV_32F,
                 const_cast<float*>(f.descriptors.get()));
}

Pairs opencv_pairs(const Features& a, const Features& b) {
  std::vector<cv::DMatch> found;
  cv::BFMatcher(cv::NORM_L2, true).match(as_mat(a), as_mat(b), found);
  Pairs pairs;
  for (const cv::DMatch& m : found) pairs.emplace_back(m.queryIdx, m.trainIdx);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

Pairs our_pairs(const Features& a, const Features& b) {
  MatchNearest::Scratch scratch;
  Matches matches;
  MatchNearest(MatchNearest::Options{1, 0})(a, b, matches, scratch);
  Pairs pairs;
  for (const Match& m : matches) pairs.emplace_back(m.previous, m.current);
  return pairs;
}

TEST(NearestAndOpenCv, FindTheSamePairsOfRandomDescriptors) {
  const Features a = random_features(500, 1), b = random_features(431, 2), c = seen_again(a, 0.1f, 3);
  EXPECT_EQ(our_pairs(a, b), opencv_pairs(a, b));
  EXPECT_EQ(our_pairs(a, c), opencv_pairs(a, c));
}

/// The reference descriptors of real pictures: even lines against odd ones.
TEST(NearestAndOpenCv, FindTheSamePairsOfRealDescriptors) {
  PAVO_NEEDS_DATA("surf/upright-size20.txt");
  std::ifstream file(data_folder() / "surf" / "upright-size20.txt");
  Features halves[2];
  for (Features& half : halves) half.reserve(400);
  std::string line;
  for (std::size_t n = 0; std::getline(file, line); ++n) {
    std::istringstream numbers(line);
    float x = 0, y = 0, size = 0, angle = 0;
    if (!(numbers >> x >> y >> size >> angle)) continue;
    Features& half = halves[n % 2];
    ASSERT_LT(half.size(), half.capacity);
    half.keypoints.push_back({x, y, 1, 0});
    float* d = half.descriptor(half.size() - 1);
    for (int k = 0; k < Features::kDescriptorSize; ++k) ASSERT_TRUE(numbers >> d[k]) << line;
  }
  ASSERT_GT(halves[0].size(), 100U);
  EXPECT_EQ(our_pairs(halves[0], halves[1]), opencv_pairs(halves[0], halves[1]));
}

}  // namespace
}  // namespace pavo::test
