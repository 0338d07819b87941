#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "stages/people/people_mask.h"

namespace pavo {
namespace {

TEST(FeaturesOnPeople, InsideIsDroppedOutsideIsKept) {
  const People people{{100, 50, 40, 100, 1}, {130, 60, 40, 100, 1}, {-20, -10, 30, 60, 1}};
  const std::vector<Keypoint> keypoints{{120, 100}, {101, 100}, {120, 51}, {150, 100}, {135, 100}, {2, 3}, {300, 100}};
  std::vector<std::uint8_t> keep(keypoints.size(), 7);
  const std::size_t dropped = features_on_people(keypoints, people, keep, {0.9f, 0.95f});
  EXPECT_EQ(keep, (std::vector<std::uint8_t>{0, 1, 1, 0, 0, 0, 1}));
  EXPECT_EQ(dropped, 4u);
}

TEST(FeaturesOnPeople, TheOutlineIsTheScaledBoxWithItsEdge) {
  const std::vector<Keypoint> keypoints{{100, 50}, {140, 150}, {99.9f, 100}, {120, 150.1f}};
  std::vector<std::uint8_t> keep(keypoints.size());
  features_on_people(keypoints, {{100, 50, 40, 100, 1}}, keep, {1, 1});
  EXPECT_EQ(keep, (std::vector<std::uint8_t>{0, 0, 1, 1}));
}

TEST(FeaturesOnPeople, NobodyDropsNothing) {
  const std::vector<Keypoint> keypoints{{1, 2}, {3, 4}};
  std::vector<std::uint8_t> keep(2);
  EXPECT_EQ(features_on_people(keypoints, {}, keep), 0u);
  EXPECT_EQ(keep, (std::vector<std::uint8_t>{1, 1}));
  EXPECT_EQ(features_on_people({}, {{0, 0, 1, 1, 1}}, {}), 0u);
}

TEST(FeaturesOnPeople, OneElementPerKeypoint) {
  const std::vector<Keypoint> keypoints{{1, 2}};
  std::vector<std::uint8_t> keep(2);
  EXPECT_THROW(features_on_people(keypoints, {}, keep), std::invalid_argument);
}

}  // namespace
}  // namespace pavo
