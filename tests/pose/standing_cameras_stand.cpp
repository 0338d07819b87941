#include <gtest/gtest.h>

#include "stages/pose/standstill.h"
#include "tests/pose/scenes.h"

namespace pavo::test {
namespace {

bool stands(const PointPairs& pairs) {
  std::vector<std::uint8_t> at_rest;
  return stands_still(pairs, kCamera, {}, at_rest);
}

PointPairs moved(const Eigen::Vector3d& rotation, const Eigen::Vector3d& t, double noise_px, double outliers = 0) {
  return pairs_of({.outlier_share = outliers, .noise_px = noise_px, .T_c_p = motion(rotation, t)});
}

TEST(Standstill, IsSeenThroughNoiseAndPassersBy) {
  EXPECT_TRUE(stands(moved({0, 0, 0}, {0, 0, 0}, 0)));
  EXPECT_TRUE(stands(moved({0, 0, 0}, {0, 0, 0}, 0.1)));
  EXPECT_TRUE(stands(moved({0, 0, 0}, {0, 0, 0}, 0.1, 0.4)));
}

TEST(Standstill, IsSeenThroughVibration) {
  EXPECT_TRUE(stands(moved({0.0005, -0.0015, 0.001}, {0, 0, 0}, 0.07)));
  EXPECT_TRUE(stands(moved({0.0005, -0.0015, 0.001}, {0, 0, 0}, 0.07, 0.3)));
}

TEST(Standstill, SlowMotionIsMotion) {
  for (const double metres : {0.05, 0.1, 0.5, 2.0}) EXPECT_FALSE(stands(moved({0, 0, 0}, {0, 0, -metres}, 0.05)));
  EXPECT_FALSE(stands(moved({0, 0, 0}, {0.05, 0, 0}, 0.05)));
  EXPECT_FALSE(stands(moved({0.0005, 0.001, 0}, {0, 0, -0.1}, 0.05)));
}

// A car ahead, at the same speed, with as many corners as the whole street.
TEST(Standstill, CountsThePictureAndNotTheCorners) {
  PointPairs pairs = moved({0, 0, 0}, {0, 0, -0.8}, 0.05);
  const std::size_t street = pairs.size();
  for (std::size_t i = 0; i < 3 * street / 2; ++i) {
    const auto x = 560 + static_cast<float>(i % 40) * 2, y = 170 + static_cast<float>(i / 40) * 4;
    pairs.push_back({x, y, x, y});
  }
  EXPECT_FALSE(stands(pairs));
}

TEST(Standstill, TurningIsMotion) {
  EXPECT_FALSE(stands(moved({0, 0.01, 0}, {0, 0, 0}, 0.05)));
}

TEST(Standstill, FewMatchesProveNothing) {
  const PointPairs pairs = moved({0, 0, 0}, {0, 0, 0}, 0);
  EXPECT_FALSE(stands({}));
  EXPECT_FALSE(stands(PointPairs(pairs.begin(), pairs.begin() + 19)));
  EXPECT_TRUE(stands(PointPairs(pairs.begin(), pairs.begin() + 20)));
}

TEST(Standstill, MarksWhoIsAtRest) {
  std::vector<std::uint8_t> truth, at_rest;
  const PointPairs pairs =
      pairs_of({.outlier_share = 0.3, .noise_px = 0.05, .T_c_p = motion({0, 0.001, 0}, {0, 0, 0})}, &truth);
  ASSERT_TRUE(stands_still(pairs, kCamera, {}, at_rest));
  EXPECT_EQ(at_rest, truth);
}

TEST(Standstill, SmallRotationIsTheTrueOne) {
  const Eigen::Vector3d truth(0.0004, -0.0012, 0.002);
  const Eigen::Vector3d found = small_rotation(moved(truth, {0, 0, 0}, 0.1, 0.3), kCamera);
  EXPECT_LT((found - truth).norm(), 5e-5);
  EXPECT_TRUE(small_rotation(PointPairs(30, PointPair{9, 9, 10, 10}), kCamera).allFinite());
}

}  // namespace
}  // namespace pavo::test
