#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "stages/matches/nearest.h"
#include "tests/matches/random_features.h"

namespace pavo::test {
namespace {

TEST(NearestKeep, EqualsBruteForceWithoutTheFeaturesThatAreNotKept) {
  const Features a = random_features(300, 1), b = seen_again(a, 0.1f, 2);
  const BruteForce brute_force(a, b);
  std::mt19937 random(3);
  MatchNearest::Scratch scratch;
  Matches matches;
  for (int n = 0; n < 10; ++n) {
    std::vector<std::uint8_t> keep_a(a.size()), keep_b(b.size());
    for (auto& keep : keep_a) keep = random() % 10 < static_cast<unsigned>(n) ? 255 : 0;
    for (auto& keep : keep_b) keep = random() % 4 != 0;
    MatchNearest()(a, b, keep_a, keep_b, matches, scratch);
    EXPECT_TRUE(equal(matches, brute_force.mutual(static_cast<double>(0.8f), keep_a, keep_b)));
    MatchNearest()(a, b, {}, keep_b, matches, scratch);
    EXPECT_TRUE(equal(matches, brute_force.mutual(static_cast<double>(0.8f), {}, keep_b)));
    MatchNearest()(a, b, keep_a, {}, matches, scratch);
    EXPECT_TRUE(equal(matches, brute_force.mutual(static_cast<double>(0.8f), keep_a, {})));
  }
}

TEST(NearestKeep, NoneKeptMatchesNothing) {
  const Features a = random_features(30, 1);
  const std::vector<std::uint8_t> none(a.size(), 0);
  MatchNearest::Scratch scratch;
  Matches matches{{1, 2, 3}};  // from before
  MatchNearest()(a, a, none, {}, matches, scratch);
  EXPECT_TRUE(matches.empty());
  MatchNearest()(a, a, {}, none, matches, scratch);
  EXPECT_TRUE(matches.empty());
}

TEST(NearestKeep, FlagsOfAnotherNumberThanTheKeypointsAreAnError) {
  const Features a = random_features(30, 1);
  const std::vector<std::uint8_t> flags(29, 1);
  MatchNearest::Scratch scratch;
  Matches matches;
  EXPECT_THROW(MatchNearest()(a, a, flags, {}, matches, scratch), std::invalid_argument);
  EXPECT_THROW(MatchNearest()(a, a, {}, flags, matches, scratch), std::invalid_argument);
}

TEST(NearestKeep, DescriptorsThatAreNoNumbersMatchNothing) {
  Features a = random_features(50, 1);
  const Features b = random_features(50, 1);
  a.descriptor(7)[3] = std::numeric_limits<float>::quiet_NaN();
  a.descriptor(8)[0] = std::numeric_limits<float>::infinity();
  a.descriptor(9)[63] = -std::numeric_limits<float>::max();
  MatchNearest::Scratch scratch;
  Matches matches;
  MatchNearest()(a, b, matches, scratch);
  EXPECT_EQ(matches.size(), 47U);
  MatchNearest()(b, a, matches, scratch);
  EXPECT_EQ(matches.size(), 47U);
}

TEST(NearestKeep, PairsThatMovedTooFarAreDropped) {
  Features a = random_features(3, 1), b = random_features(3, 1);
  for (std::size_t i = 0; i < 3; ++i) {
    a.keypoints[i] = {100, 100, 1, 0};
    b.keypoints[i] = {100 + 3 * static_cast<float>(i), 100 + 4 * static_cast<float>(i), 1, 0};
  }
  MatchNearest::Scratch scratch;
  Matches matches;
  MatchNearest(MatchNearest::Options{0.8f, 5})(a, b, matches, scratch);
  EXPECT_EQ(matches.size(), 2U);
  MatchNearest(MatchNearest::Options{0.8f, 4.9f})(a, b, matches, scratch);
  EXPECT_EQ(matches.size(), 1U);
  PointPairs pairs;
  MatchNearest()(a, b, matches, scratch);
  pairs_of(matches, a, b, pairs);
  ASSERT_EQ(pairs.size(), 3U);
  EXPECT_EQ(pairs[2].x_previous, 100);
  EXPECT_EQ(pairs[2].x_current, 106);
  EXPECT_EQ(pairs[2].y_current, 108);
}

TEST(NearestOptions, MustBePositiveNumbers) {
  EXPECT_THROW(MatchNearest(MatchNearest::Options{0, 0}), std::invalid_argument);
  EXPECT_THROW(MatchNearest(MatchNearest::Options{std::nanf(""), 0}), std::invalid_argument);
  EXPECT_THROW(MatchNearest(MatchNearest::Options{0.8f, -1}), std::invalid_argument);
}

}  // namespace
}  // namespace pavo::test
