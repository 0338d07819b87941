#include "stages/pose/eight_point.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <opencv2/calib3d.hpp>

#include "stages/pose/essential.h"
#include "stages/pose/sampson.h"
#include "tests/pose/scenes.h"

namespace pavo::test {
namespace {

Eigen::Matrix3d fundamental_of(const SE3& T_c_p) {
  const Eigen::Matrix3d K_inverse = intrinsic_matrix(kCamera).inverse();
  const Eigen::Matrix3d F = K_inverse.transpose() * essential_of(T_c_p) * K_inverse;
  return F / F.norm();
}

double difference(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return std::min((a - b).norm(), (a + b).norm());
}

double worst_distance(const Eigen::Matrix3d& F, const PointPairs& pairs) {
  double worst = 0;
  for (const PointPair& pair : pairs) worst = std::max(worst, sampson_distance(F, pair));
  return worst;
}

TEST(EightPoint, IsExactWithoutNoise) {
  const PointPairs pairs = pairs_of({.points = 60, .noise_px = 0});
  const Eigen::Matrix3d F = eight_point(pairs);
  EXPECT_LT(difference(F, fundamental_of(driving())), 1e-5);
  EXPECT_LT(worst_distance(F, pairs), 1e-3);
  EXPECT_NEAR(F.determinant(), 0, 1e-15);
  EXPECT_NEAR(F.norm(), 1, 1e-12);
}

TEST(EightPoint, AgreesWithOpenCV) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const PointPairs pairs = pairs_of({.points = 100, .noise_px = 0.5, .seed = seed});
    std::vector<cv::Point2f> previous, current;
    for (const PointPair& p : pairs) previous.emplace_back(p.x_previous, p.y_previous);
    for (const PointPair& p : pairs) current.emplace_back(p.x_current, p.y_current);
    const cv::Mat theirs = cv::findFundamentalMat(previous, current, cv::FM_8POINT);
    Eigen::Matrix3d F;
    for (int i = 0; i < 9; ++i) F(i / 3, i % 3) = theirs.at<double>(i / 3, i % 3);
    // The same algorithm but for the measure of the spread (root mean square here, mean there).
    double ours_sum = 0, theirs_sum = 0;
    const Eigen::Matrix3d ours = eight_point(pairs);
    for (const PointPair& p : pairs) {
      ours_sum += sampson_distance(ours, p);
      theirs_sum += sampson_distance(F, p);
    }
    EXPECT_NEAR(ours_sum / theirs_sum, 1, 0.05) << seed;
  }
}

TEST(EightPoint, MinimalSolutionPassesThroughItsSample) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const PointPairs pairs = pairs_of({.points = 8, .noise_px = 1, .seed = seed});
    const PairNormalisation by = normalisation_of(pairs);
    std::array<NormalisedPair, 8> sample;
    for (std::size_t i = 0; i < 8; ++i) sample[i] = normalised(pairs[i], by);
    Eigen::Matrix3d F;
    ASSERT_TRUE(eight_point_minimal(sample, F));
    EXPECT_NEAR(F.norm(), 1, 1e-12);
    EightPointSystem system;
    for (const NormalisedPair& p : sample) {
      const Eigen::Vector3d x(p[0], p[1], 1), y(p[2], p[3], 1);
      EXPECT_NEAR(y.dot(F * x), 0, 1e-9);
      system.add(p, 1);
    }
    EXPECT_LT(difference(F, system.solve()), 1e-5);  // least squares squares the condition
  }
}

TEST(EightPoint, DegenerateSamplesAreTold) {
  std::array<NormalisedPair, 8> sample;
  sample.fill({0.1, 0.2, 0.3, 0.4});
  Eigen::Matrix3d F;
  EXPECT_FALSE(eight_point_minimal(sample, F));
  const PointPairs plane = pairs_of({.points = 8, .noise_px = 0, .shape = Shape::plane, .T_c_p = SE3{}});
  EXPECT_THROW(eight_point(std::span(plane).first(7)), std::invalid_argument);
}

TEST(EightPoint, IdenticalPointsGiveNumbers) {
  const PointPairs pairs(20, PointPair{100, 100, 100, 100});
  EXPECT_TRUE(eight_point(pairs).allFinite());
}

TEST(EightPoint, NormalisationCentersAndScales) {
  const PointPairs pairs = pairs_of({.points = 50});
  const PairNormalisation by = normalisation_of(pairs);
  double x = 0, y = 0, square = 0;
  for (const PointPair& pair : pairs) {
    const NormalisedPair n = normalised(pair, by);
    x += n[2], y += n[3], square += n[2] * n[2] + n[3] * n[3];
  }
  EXPECT_NEAR(x, 0, 1e-9);
  EXPECT_NEAR(y, 0, 1e-9);
  EXPECT_NEAR(square / 50, 2, 1e-9);
}

TEST(EightPoint, BothWaysToRank2Agree) {
  Random random(5);
  for (int n = 0; n < 100; ++n) {
    Eigen::Matrix3d F;
    for (int i = 0; i < 9; ++i) F(i / 3, i % 3) = gauss(random);
    const Eigen::Matrix3d exact = nearest_rank2(F);
    EXPECT_NEAR(exact.determinant(), 0, 1e-12);
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(F);
    EXPECT_NEAR((F - exact).norm(), svd.singularValues()[2], 1e-12);
    // Near rank 2, as samples of real matches are.
    const Eigen::Matrix3d near = exact + 1e-3 * F;
    EXPECT_LT((rank2_by_iteration(near) - nearest_rank2(near)).norm(), 1e-6);
  }
}

}  // namespace
}  // namespace pavo::test
