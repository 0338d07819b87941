#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "stages/features/extract.h"
#include "tests/features/pictures.h"

namespace pavo::test {
namespace {

using Cell = std::pair<int, int>;

std::vector<Corner> random_corners(int width, int height, std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Corner> corners;
  for (std::size_t i = 0; i < n; ++i) {
    // Squared: most of them are in the top left, as in a picture with one rich facade.
    const double x = static_cast<double>(random() % 1000) / 1000, y = static_cast<double>(random() % 1000) / 1000;
    corners.push_back({static_cast<std::uint16_t>(x * x * width), static_cast<std::uint16_t>(y * y * height),
                       static_cast<std::uint8_t>(7 + random() % 30)});
  }
  return corners;
}

std::map<Cell, std::vector<int>> scores_by_cell(std::span<const Corner> corners, int cell_size) {
  std::map<Cell, std::vector<int>> scores;
  for (const Corner& c : corners) scores[{c.y / cell_size, c.x / cell_size}].push_back(c.score);
  for (auto& [cell, list] : scores) std::sort(list.rbegin(), list.rend());
  return scores;
}

TEST(CornerGrid, KeepsAsManyAsItMay) {
  CornerGrid::Scratch scratch;
  for (int most : {1, 2, 7, 50, 333, 999, 1000, 1001, 5000}) {
    std::vector<Corner> corners = random_corners(640, 300, 1000, 1);
    EXPECT_EQ(CornerGrid(640, 300, 64, most).keep_best(corners, scratch).size(), std::min<std::size_t>(most, 1000u));
  }
}

TEST(CornerGrid, KeepsTheStrongestOfEveryCellAndTheSameNumberWhereItCan) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const std::vector<Corner> corners = random_corners(640, 300, 2000, seed);
    std::vector<Corner> kept = corners;
    CornerGrid::Scratch scratch;
    const auto before = scores_by_cell(corners, 64);
    auto after = scores_by_cell(CornerGrid(640, 300, 64, 500).keep_best(kept, scratch), 64);
    std::size_t fewest = 2000, most = 0;
    for (const auto& [cell, all] : before) {
      const std::vector<int>& best = after[cell];
      EXPECT_TRUE(std::equal(best.begin(), best.end(), all.begin()));
      most = std::max(most, best.size());
      if (best.size() < all.size()) fewest = std::min(fewest, best.size());
    }
    EXPECT_LE(most, fewest + 1) << "a cell had to give up corners while another one keeps more";
  }
}

TEST(CornerGrid, KeepsTheOrder) {
  std::vector<Corner> corners = random_corners(640, 300, 2000, 3);
  const auto earlier = [](const Corner& a, const Corner& b) { return std::pair(a.y, a.x) < std::pair(b.y, b.x); };
  std::sort(corners.begin(), corners.end(), earlier);
  CornerGrid::Scratch scratch;
  const std::span<const Corner> kept = CornerGrid(640, 300, 50, 400).keep_best(corners, scratch);
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end(), earlier));
}

/// One half with hard contrast, one with a tenth of it: the weak half must not be left empty.
TEST(Keypoints, AreFoundInFaintPartsToo) {
  cv::Mat picture = street(640, 320, 5);
  cv::Mat faint = picture(cv::Rect(320, 0, 320, 320));
  faint = faint * 0.15 + 100;
  ExtractFeatures::Scratch scratch;
  Features features;
  ExtractFeatures({.max_features = 400}, 640, 320)(image(picture), features, scratch);
  EXPECT_EQ(features.size(), 400u);
  const auto right =
      std::count_if(features.keypoints.begin(), features.keypoints.end(), [](const Keypoint& k) { return k.x >= 320; });
  EXPECT_GE(right, 120);
  for (const Keypoint& k : features.keypoints) EXPECT_GE(k.response, FeatureOptions{}.min_score);
}

TEST(Keypoints, AreTheSameOnEveryRunAndWithEveryScratch) {
  const Image picture = image(street(320, 200, 6)), other = image(street(320, 200, 7));
  const ExtractFeatures extract({.max_features = 200, .oriented = true}, 320, 200);
  ExtractFeatures::Scratch used, fresh;
  Features a, b;
  extract(other, a, used);
  extract(picture, a, used);
  extract(picture, b, fresh);
  ASSERT_EQ(a.size(), b.size());
  EXPECT_TRUE(std::equal(a.descriptor(0), a.descriptor(a.size()), b.descriptor(0)));
}

TEST(Keypoints, DoNotExistWithoutTextureOrRoom) {
  ExtractFeatures::Scratch scratch;
  Features features;
  for (int gray : {0, 255}) {
    ExtractFeatures({}, 100, 60)(image(cv::Mat(60, 100, CV_8U, cv::Scalar(gray))), features, scratch);
    EXPECT_EQ(features.size(), 0u);
  }
  for (int size : {1, 6, 7, 20, 24}) {
    ExtractFeatures({}, size, 60)(image(noise(size, 60, 1)), features, scratch);
    EXPECT_EQ(features.size(), 0u);
    ExtractFeatures({}, 60, size)(image(noise(60, size, 1)), features, scratch);
    EXPECT_EQ(features.size(), 0u);
  }
  ExtractFeatures({}, 0, 0)(Image(), features, scratch);
  EXPECT_EQ(features.size(), 0u);
}

}  // namespace
}  // namespace pavo::test
