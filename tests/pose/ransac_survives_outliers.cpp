#include "stages/pose/ransac.h"

#include <gtest/gtest.h>

#include "stages/pose/essential.h"
#include "tests/pose/scenes.h"

namespace pavo::test {
namespace {

TEST(Ransac, FindsTheInliersAmongOutliers) {
  RansacScratch scratch;
  std::vector<std::uint8_t> flags, truth;
  for (const double share : {0.0, 0.2, 0.4, 0.6}) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const PointPairs pairs = pairs_of({.points = 300, .outlier_share = share, .seed = seed}, &truth);
      const RansacResult result = ransac_fundamental(pairs, {.max_iterations = 8000}, Random(seed), flags, scratch);
      ASSERT_TRUE(result.found);
      int missed = 0, wrong = 0, good = 0;
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        good += truth[i];
        missed += truth[i] && !flags[i];
        wrong += !truth[i] && flags[i];
      }
      EXPECT_LT(missed, (share < 0.5 ? 0.05 : 0.25) * good) << share << " " << seed;
      EXPECT_LT(wrong, 0.05 * 300 * share + 1) << share << " " << seed;
      EXPECT_NEAR(result.F.determinant(), 0, 1e-12);
      EXPECT_TRUE(result.candidates[0].isApprox(result.F));
    }
  }
}

TEST(Ransac, TheMoreOutliersTheMoreSamples) {
  RansacScratch scratch;
  std::vector<std::uint8_t> flags;
  int last = 0;
  for (const double share : {0.0, 0.4, 0.5}) {
    const PointPairs pairs = pairs_of({.points = 1000, .outlier_share = share});
    const int iterations = ransac_fundamental(pairs, {}, Random(1), flags, scratch).iterations;
    EXPECT_GT(iterations, last);
    last = iterations;
  }
  // 0.6^8 of the samples are clean: ln 0.001 / ln(1 - 0.6^8) = 408 of them.
  const PointPairs pairs = pairs_of({.points = 1000, .outlier_share = 0.4});
  EXPECT_NEAR(ransac_fundamental(pairs, {}, Random(1), flags, scratch).iterations, 408, 150);
}

TEST(Ransac, SameSeedSameBits) {
  RansacScratch fresh, used;
  std::vector<std::uint8_t> flags_a, flags_b;
  ransac_fundamental(pairs_of({.points = 777, .seed = 9}), {}, Random(4), flags_b, used);
  const PointPairs pairs = pairs_of({.points = 500, .outlier_share = 0.4});
  const RansacResult a = ransac_fundamental(pairs, {}, Random(7), flags_a, fresh);
  const RansacResult b = ransac_fundamental(pairs, {}, Random(7), flags_b, used);
  EXPECT_TRUE(a.F == b.F);
  EXPECT_EQ(flags_a, flags_b);
  EXPECT_EQ(a.iterations, b.iterations);
}

TEST(Ransac, TooLittleIsNothing) {
  RansacScratch scratch;
  std::vector<std::uint8_t> flags;
  for (std::size_t n = 0; n <= 7; ++n) {
    const RansacResult result = ransac_fundamental(pairs_of({.points = n}), {}, Random(1), flags, scratch);
    EXPECT_FALSE(result.found);
    EXPECT_EQ(flags, std::vector<std::uint8_t>(n, 0));
  }
}

TEST(Ransac, DegenerateInputGivesNumbersOrNothing) {
  RansacScratch scratch;
  std::vector<std::uint8_t> flags;
  const PointPairs same(50, PointPair{10, 20, 30, 40});
  EXPECT_FALSE(ransac_fundamental(same, {.max_iterations = 200}, Random(1), flags, scratch).found);
  PointPairs line;
  for (int i = 0; i < 60; ++i) {
    const auto x = static_cast<float>(i * 10);
    line.push_back({x, 100, x + 3, 100});
  }
  const RansacResult result = ransac_fundamental(line, {.max_iterations = 200}, Random(1), flags, scratch);
  EXPECT_TRUE(result.F.allFinite());
}

TEST(Ransac, NoiseAloneIsNoGeometry) {
  RansacScratch scratch;
  std::vector<std::uint8_t> flags;
  const PointPairs pairs = pairs_of({.points = 150, .outlier_share = 1});
  const RansacResult result =
      ransac_fundamental(pairs, {.max_iterations = 500, .min_inliers = 30}, Random(1), flags, scratch);
  EXPECT_FALSE(result.found);
}

TEST(RandomNumbers, AreThePublishedOnes) {
  Random random(1234567);  // the reference implementation's first outputs for this seed
  EXPECT_EQ(random.next(), 6457827717110365317u);
  EXPECT_EQ(random.next(), 3203168211198807973u);
  EXPECT_EQ(random.next(), 9817491932198370423u);
  EXPECT_NE(Random::for_frame(1, 2).next(), Random::for_frame(2, 1).next());
  for (int i = 0; i < 1000; ++i) EXPECT_LT(random.below(7), 7u);
}

}  // namespace
}  // namespace pavo::test
