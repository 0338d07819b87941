#include "stages/pose/sampson.h"

#include <gtest/gtest.h>

#include <cmath>

#include "stages/pose/eight_point.h"
#include "tests/pose/scenes.h"
#include "tests/support/simd_targets.h"

namespace pavo::test {
namespace {

// Sizes around the vectors' and the blocks'.
constexpr std::size_t kSizes[] = {1, 2, 7, 8, 9, 15, 16, 17, 127, 128, 129, 300};

TEST(Sampson, AgreesWithDoublePrecision) {
  for (const std::int64_t target : simd_targets()) {
    const ForceTarget force(target);
    SampsonPoints points;
    const Eigen::Matrix3d F = eight_point(pairs_of({.points = 50, .noise_px = 0.3}));
    for (const std::size_t n : kSizes) {
      const PointPairs pairs = pairs_of({.points = n, .outlier_share = 0.3, .seed = n});
      points.assign(pairs);
      const SampsonModel model = sampson_model(F, points);
      std::vector<std::uint8_t> flags(n);
      const int count = sampson_inliers(points, model, 1, flags);
      double cost = 0;
      int inliers = 0;
      for (std::size_t i = 0; i < n; ++i) {
        const double d = sampson_distance(F, pairs[i]);
        cost += std::min(d * d, 1.0);
        if (std::abs(d - 1) > 0.01) {
          EXPECT_EQ(flags[i], d <= 1) << hwy::TargetName(target) << " " << n << " " << i;
        }
        inliers += flags[i];
      }
      EXPECT_EQ(count, inliers);
      EXPECT_NEAR(sampson_cost(points, model, 1, 1e9f), cost, 0.002 * cost + 0.01) << hwy::TargetName(target);
    }
  }
}

TEST(Sampson, GivingUpIsExact) {
  SampsonPoints points;
  const PointPairs pairs = pairs_of({.points = 1000, .outlier_share = 0.5});
  points.assign(pairs);
  const SampsonModel model = sampson_model(eight_point(pairs), points);
  const float full = sampson_cost(points, model, 1, 1e9f);
  EXPECT_EQ(sampson_cost(points, model, 1, full), full);  // not above it: not given up
  const float early = sampson_cost(points, model, 1, full / 3);
  EXPECT_GT(early, full / 3);
  EXPECT_LE(early, full);
}

TEST(Sampson, BrokenModelsHaveNoInliers) {
  SampsonPoints points;
  points.assign(pairs_of({.points = 40}));
  std::vector<std::uint8_t> flags(40);
  const Eigen::Matrix3d nan = Eigen::Matrix3d::Constant(std::nan(""));
  EXPECT_EQ(sampson_inliers(points, sampson_model(nan, points), 1, flags), 0);
}

}  // namespace
}  // namespace pavo::test
