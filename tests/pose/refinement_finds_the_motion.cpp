#include "stages/pose/refine_motion.h"

#include <gtest/gtest.h>

#include "stages/pose/eight_point.h"
#include "stages/pose/essential.h"
#include "tests/pose/scenes.h"
#include "tests/support/simd_targets.h"

namespace pavo::test {
namespace {

SE3 disturbed(const SE3& T, Random& random) {
  SE3 result = motion({0.001 * gauss(random), 0.001 * gauss(random), 0.001 * gauss(random)}, {0, 0, 0});
  result.R = result.R * T.R;
  result.t = (T.t.normalized() + 0.03 * Eigen::Vector3d(gauss(random), gauss(random), gauss(random))).normalized();
  return result;
}

TEST(Refinement, IsExactWithoutNoise) {
  Random random(1);
  SampsonPoints points;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    points.assign(pairs_of({.noise_px = 0, .seed = seed}));
    SE3 T = disturbed(driving(), random);
    for (const double scale : {4.0, 2.0, 1.0, 0.5}) refine_motion(points, kCamera, {scale, 20}, T);
    EXPECT_LT(degrees_between(T.R, driving().R), 0.01);
    EXPECT_LT(degrees_between(T.t, driving().t), 0.05);
    EXPECT_TRUE(orthonormal(T.R));
    EXPECT_NEAR(T.t.norm(), 1, 1e-12);
  }
}

TEST(Refinement, NeverGetsWorse) {
  Random random(2);
  SampsonPoints points;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    points.assign(pairs_of({.points = 100, .outlier_share = 0.5, .noise_px = 1, .seed = seed}));
    SE3 T = disturbed(disturbed(driving(), random), random);
    const double before = refine_motion(points, kCamera, {0.5, 0}, T);
    const double after = refine_motion(points, kCamera, {}, T);
    EXPECT_LE(after, before * (1 + 1e-9));
  }
}

TEST(Refinement, BeatsTheEightPoint) {
  double eight = 0, refined = 0;
  SampsonPoints points;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const PointPairs pairs = pairs_of({.points = 300, .noise_px = 0.2, .seed = seed});
    const std::vector<std::uint8_t> use(pairs.size(), 1);
    SE3 T = motion_in_front(essential_from_fundamental(eight_point(pairs), kCamera), pairs, use, kCamera, 0.5).T_c_p;
    eight += degrees_between(T.t, driving().t);
    points.assign(pairs);
    refine_motion(points, kCamera, {}, T);
    refined += degrees_between(T.t, driving().t);
  }
  EXPECT_LT(refined, 0.9 * eight);
}

TEST(Refinement, AgreesOnEveryTarget) {
  SampsonPoints points;
  points.assign(pairs_of({.points = 333, .outlier_share = 0.2}));
  Random random(3);
  const SE3 start = disturbed(driving(), random);
  SE3 first;
  bool have_first = false;
  for (const std::int64_t target : simd_targets()) {
    const ForceTarget force(target);
    SE3 T = start;
    refine_motion(points, kCamera, {1, 20}, T);
    refine_motion(points, kCamera, {0.5, 20}, T);
    if (!have_first) first = T;
    have_first = true;
    EXPECT_LT(degrees_between(T.R, first.R), 1e-3) << hwy::TargetName(target);
    EXPECT_LT(degrees_between(T.t, first.t), 2e-2) << hwy::TargetName(target);
  }
}

TEST(Refinement, DegenerateInputGivesNumbers) {
  SampsonPoints points;
  for (const std::size_t n : {0, 1, 4, 5, 50}) {
    points.assign(PointPairs(n, PointPair{5, 6, 7, 8}));
    SE3 T = driving();
    T.t.normalize();
    refine_motion(points, kCamera, {}, T);
    EXPECT_TRUE(T.R.allFinite() && T.t.allFinite());
  }
}

}  // namespace
}  // namespace pavo::test
