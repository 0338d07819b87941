#include <gtest/gtest.h>

#include <string>

#include "stages/matches/nearest.h"
#include "tests/matches/random_features.h"
#include "tests/support/simd_targets.h"

namespace pavo::test {
namespace {

MatchNearest matcher(float ratio) {
  return MatchNearest(MatchNearest::Options{ratio, 0});
}

TEST(Nearest, EqualsBruteForceForEverySizeOnEveryTarget) {
  for (const std::int64_t target : simd_targets()) {
    const ForceTarget force(target);
    MatchNearest::Scratch scratch;  // the same for growing and shrinking sizes
    Matches matches;
    for (const std::size_t rows : {0, 1, 2, 3, 4, 5, 63, 200})
      for (const std::size_t columns : {0, 1, 2, 11, 12, 13, 24, 47, 48, 49, 63, 150}) {
        const auto seed = static_cast<std::uint32_t>(1000 * rows + columns);
        const Features a = random_features(rows, seed), b = random_features(columns, seed + 1);
        for (const float ratio : {0.8f, 0.95f, 1.0f}) {
          matcher(ratio)(a, b, matches, scratch);
          EXPECT_TRUE(equal(matches, BruteForce(a, b).mutual(static_cast<double>(ratio))))
              << rows << " x " << columns << ", ratio " << ratio << ", target " << hwy::TargetName(target);
        }
      }
  }
}

TEST(Nearest, EqualsBruteForceAtWorkingSizes) {
  const Features a = random_features(1500, 1), b = seen_again(a, 0.08f, 2), c = random_features(400, 3);
  const Matches expected = BruteForce(a, b).mutual(static_cast<double>(0.8f));
  EXPECT_GT(expected.size(), 500U);
  const BruteForce other_size(a, c);
  for (const std::int64_t target : simd_targets()) {
    const ForceTarget force(target);
    MatchNearest::Scratch scratch;
    Matches matches;
    matcher(0.8f)(a, b, matches, scratch);
    EXPECT_TRUE(equal(matches, expected)) << hwy::TargetName(target);
    matcher(1)(a, c, matches, scratch);
    EXPECT_TRUE(equal(matches, other_size.mutual(1))) << hwy::TargetName(target);
  }
}

/// Distances far below what a float dot product can tell apart: the float kernel alone would fail here.
TEST(Nearest, NearTiesAreDecidedInDouble) {
  const Features a = random_features(60, 5);
  Features b = random_features(300, 6);
  std::mt19937 random(7);
  for (std::size_t j = 0; j < 240; ++j)  // four near-copies of each, whose distances differ in the seventh digit
    for (int k = 0; k < Features::kDescriptorSize; ++k)
      b.descriptor(j)[k] = a.descriptor(j % 60)[k] + (k == 5 ? 0.05f + 1e-8f * static_cast<float>(random() % 8) : 0);
  for (const std::int64_t target : simd_targets()) {
    const ForceTarget force(target);
    MatchNearest::Scratch scratch;
    Matches matches;
    for (const float ratio : {0.99999f, 1.0f}) {
      matcher(ratio)(a, b, matches, scratch);
      EXPECT_TRUE(equal(matches, BruteForce(a, b).mutual(static_cast<double>(ratio)))) << hwy::TargetName(target);
      matcher(ratio)(b, a, matches, scratch);
      EXPECT_TRUE(equal(matches, BruteForce(b, a).mutual(static_cast<double>(ratio)))) << hwy::TargetName(target);
    }
  }
}

TEST(Nearest, NeedsNoUnitLength) {
  Features a = random_features(100, 8), b = seen_again(a, 0.1f, 9);
  for (std::size_t i = 0; i < 100; ++i)
    for (int k = 0; k < Features::kDescriptorSize; ++k) {
      a.descriptor(i)[k] *= static_cast<float>(1 + i % 3);
      b.descriptor(i)[k] *= i % 10 == 0 ? 0.0f : 30.0f;  // some are zero
    }
  MatchNearest::Scratch scratch;
  Matches matches;
  matcher(1)(a, b, matches, scratch);
  EXPECT_TRUE(equal(matches, BruteForce(a, b).mutual(1)));
}

}  // namespace
}  // namespace pavo::test
