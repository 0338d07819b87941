#include <gtest/gtest.h>

#include <algorithm>

#include "stages/matches/nearest.h"
#include "tests/matches/random_features.h"
#include "tests/support/simd_targets.h"

namespace pavo::test {
namespace {

void copy(const Features& from, std::size_t i, Features& to, std::size_t j) {
  std::copy_n(from.descriptor(i), Features::kDescriptorSize, to.descriptor(j));
}

TEST(NearestTies, OfEqualDescriptorsTheFirstIsTheNearest) {
  const Features a = random_features(70, 1);
  Features b = random_features(140, 2);
  for (std::size_t j = 0; j < 140; ++j) copy(a, j % 70, b, j);  // each twice
  for (const std::int64_t target : simd_targets()) {
    const ForceTarget force(target);
    MatchNearest::Scratch scratch;
    Matches matches;
    const MatchNearest match(MatchNearest::Options{1, 0});
    match(a, b, matches, scratch);
    ASSERT_EQ(matches.size(), 70U);
    for (int i = 0; i < 70; ++i) {
      EXPECT_EQ(matches[static_cast<std::size_t>(i)].previous, i);
      EXPECT_EQ(matches[static_cast<std::size_t>(i)].current, i);
      EXPECT_EQ(matches[static_cast<std::size_t>(i)].distance, 0.0f);
    }
    match(b, a, matches, scratch);
    ASSERT_EQ(matches.size(), 70U);
    for (int i = 0; i < 70; ++i) EXPECT_EQ(matches[static_cast<std::size_t>(i)].previous, i);
  }
}

TEST(NearestTies, TheRatioTestDropsWhatIsThereTwice) {
  const Features a = random_features(70, 1);
  Features b = random_features(140, 2);
  for (std::size_t j = 0; j < 140; ++j) copy(a, j % 70, b, j);
  MatchNearest::Scratch scratch;
  Matches matches;
  MatchNearest()(a, b, matches, scratch);
  EXPECT_TRUE(matches.empty());
}

TEST(NearestTies, AllDescriptorsTheSameGivesOnePair) {
  Features a = random_features(130, 1), b = random_features(90, 2);
  for (std::size_t i = 1; i < 130; ++i) copy(a, 0, a, i);
  for (std::size_t i = 0; i < 90; ++i) copy(a, 0, b, i);
  MatchNearest::Scratch scratch;
  Matches matches;
  MatchNearest(MatchNearest::Options{1, 0})(a, b, matches, scratch);
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0].previous, 0);
  EXPECT_EQ(matches[0].current, 0);
}

}  // namespace
}  // namespace pavo::test
