#include "stages/pose/relative_motion.h"

#include <gtest/gtest.h>

#include "tests/pose/scenes.h"

namespace pavo::test {
namespace {

struct Estimated {
  RelativeMotion motion;
  std::vector<std::uint8_t> is_inlier;
};

Estimated estimate(const PointPairs& pairs, const RelativeMotionOptions& options = {}) {
  Estimated result;
  RelativeMotionEstimator estimator(kCamera, options);
  result.motion = estimator(pairs, Random(1), result.is_inlier);
  EXPECT_EQ(result.is_inlier.size(), pairs.size());
  EXPECT_TRUE(result.motion.T_p_c.R.allFinite() && result.motion.T_p_c.t.allFinite());
  EXPECT_EQ(std::count(result.is_inlier.begin(), result.is_inlier.end(), 1), result.motion.inliers);
  return result;
}

TEST(RelativeMotion, IsFoundWithOutliersAndNoise) {
  for (const bool refine : {false, true}) {
    for (const double share : {0.0, 0.3, 0.5}) {
      const PointPairs pairs = pairs_of({.points = 600, .outlier_share = share});
      const RelativeMotion motion = estimate(pairs, {.refine = refine}).motion;
      ASSERT_TRUE(motion.found);
      EXPECT_EQ(motion.quality, Quality::tracked);
      const SE3 truth = driving().inverse();
      EXPECT_LT(degrees_between(motion.T_p_c.R, truth.R), refine ? 0.05 : 0.3) << share;
      EXPECT_LT(degrees_between(motion.T_p_c.t, truth.t), refine ? 1 : 3) << share;
      EXPECT_NEAR(motion.T_p_c.t.norm(), 1, 1e-9);
    }
  }
}

TEST(RelativeMotion, ForwardIsNeverBackward) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const SE3 ahead = motion({0, 0, 0}, {0, 0, -1});
    const RelativeMotion found =
        estimate(pairs_of({.points = 200, .outlier_share = 0.2, .T_c_p = ahead, .seed = seed})).motion;
    ASSERT_TRUE(found.found);
    EXPECT_GT(found.T_p_c.t.z(), 0.99) << seed;
  }
}

TEST(RelativeMotion, APlaneGivesAFiniteMotionThatExplainsIt) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Estimated result = estimate(pairs_of({.shape = Shape::plane, .seed = seed}));
    ASSERT_TRUE(result.motion.found);  // the eight-point's F is not unique here, the refined E (but for a twin) is
    EXPECT_TRUE(orthonormal(result.motion.T_p_c.R));
    EXPECT_GT(result.motion.inliers, 360);
  }
}

TEST(RelativeMotion, TurningOnTheSpotHasNoTranslationToTell) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SE3 turn = motion({0.001, 0.03, 0}, {0, 0, 0});
    const RelativeMotion found = estimate(pairs_of({.noise_px = 0.1, .T_c_p = turn, .seed = seed})).motion;
    ASSERT_TRUE(found.found);
    EXPECT_EQ(found.reason, PoseReason::rotation_only);
    EXPECT_LT(degrees_between(found.T_p_c.R, turn.inverse().R), 0.05);
  }
}

TEST(RelativeMotion, FewMatchesAreTold) {
  for (std::size_t n = 0; n < 20; ++n) {
    const RelativeMotion found = estimate(pairs_of({.points = n})).motion;
    EXPECT_FALSE(found.found);
    EXPECT_EQ(found.reason, PoseReason::too_few_matches);
  }
  for (std::size_t n = 8; n < 30; ++n) estimate(pairs_of({.points = n}), {.min_matches = 0});
}

TEST(RelativeMotion, NonsenseIsNoMotion) {
  const RelativeMotion found = estimate(pairs_of({.points = 60, .outlier_share = 1})).motion;
  EXPECT_FALSE(found.found);
  EXPECT_EQ(found.reason, PoseReason::too_few_inliers);
  estimate(PointPairs(100, PointPair{50, 60, 70, 80}));
}

}  // namespace
}  // namespace pavo::test
