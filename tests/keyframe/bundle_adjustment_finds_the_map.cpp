#include <gtest/gtest.h>

#include "tests/keyframe/street_of_points.h"

namespace pavo::test {
namespace {

Eigen::Vector3d position(const RayPoint& p) {
  return p.origin + p.direction / p.rho;
}

TEST(BundleAdjustment, FindsTheTruthWithoutNoise) {
  StreetOfPoints street = street_of_points(1, 8, 80, 0);
  BundleOptions options;
  options.iterations = 30;
  options.least_gain = 1e-12;
  BundleAdjustment adjust(kCamera, options);
  EXPECT_LT(adjust(street.bundle).final_cost, 1e-8);
  for (std::size_t i = 0; i < street.T_w_c.size(); ++i)
    EXPECT_LT(step_between(street.T_w_c[i], street.bundle.poses[i].T_w_c).norm(), 1e-6) << i;
  for (std::size_t i = 0; i < street.points.size(); ++i)
    EXPECT_LT((position(street.bundle.points[i].ray) - street.points[i]).norm(), 1e-3) << i;
}

TEST(BundleAdjustment, NeverMakesItWorse) {
  for (std::uint64_t seed = 1; seed < 6; ++seed) {
    StreetOfPoints street = street_of_points(seed, 6, 40, 0.5, 0.3);
    BundleAdjustment adjust(kCamera, {});
    const BundleSummary summary = adjust(street.bundle);
    EXPECT_LE(summary.final_cost, summary.initial_cost);
    EXPECT_NEAR(adjust.cost(street.bundle), summary.final_cost, 1e-9 * summary.final_cost);
  }
}

TEST(BundleAdjustment, LeavesFixedPosesToTheBit) {
  StreetOfPoints street = street_of_points(2, 5, 40, 0.5);
  BundleAdjustment adjust(kCamera, {});
  adjust(street.bundle);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(street.bundle.poses[i].T_w_c.t, street.T_w_c[i].t);
    EXPECT_EQ(street.bundle.poses[i].T_w_c.R, street.T_w_c[i].R);
  }
}

TEST(BundleAdjustment, RefusesMorePosesThanItHasRoomFor) {
  Bundle bundle;
  bundle.poses.resize(Bundle::kMaxFree + 1);
  BundleAdjustment adjust(kCamera, {});
  EXPECT_THROW(adjust(bundle), std::invalid_argument);
}

// The analytic Jacobians against differences.
TEST(Jacobians, AreThoseOfTheProjection) {
  const SE3 T = motion({0.1, -0.2, 0.05}, {1, 2, 3});
  const RayPoint point{{0.5, 1, -1}, {0.1, -0.05, 1}, 0.07, 1};
  const auto pixel = [&](const SE3& pose, double rho) {
    RayPoint p = point;
    p.rho = rho;
    return pixel_of(kCamera, scaled_in_camera(p, pose));
  };
  const Eigen::Vector3d p = scaled_in_camera(point, T);
  const Eigen::Matrix<double, 2, 3> by_point = pixel_jacobian(kCamera, p);
  const Eigen::Matrix<double, 2, 6> J = pose_jacobian(by_point, p, point.rho);
  constexpr double h = 1e-6;
  for (int k = 0; k < 6; ++k) {
    const Vector6d step = h * Vector6d::Unit(k);
    const Eigen::Vector2d difference =
        (pixel(moved_by(T, step), point.rho) - pixel(moved_by(T, -step), point.rho)) / (2 * h);
    EXPECT_LT((difference - J.col(k)).norm(), 1e-4 * (1 + J.col(k).norm())) << k;
  }
  const Eigen::Vector2d by_rho = by_point * (T.R.transpose() * (point.origin - T.t));
  EXPECT_LT(((pixel(T, point.rho + h) - pixel(T, point.rho - h)) / (2 * h) - by_rho).norm(), 1e-3 * by_rho.norm());
}

TEST(RayPoint, IsTheSamePointFromAnotherOrigin) {
  const RayPoint point{{1, 2, 3}, {0.2, 0.1, 1}, 0.1, 0.01};
  EXPECT_LT((position(rehosted(point, {0, 0, 5}, {0, 0, 1})) - position(point)).norm(), 1e-12);
}

TEST(Se3Step, IsUndoneByItsInverse) {
  const SE3 T = motion({0.3, -0.2, 0.1}, {1, -2, 3});
  Vector6d xi;
  xi << 0.1, -0.2, 0.3, 0.05, -0.04, 0.02;
  EXPECT_LT((step_between(T, moved_by(T, xi)) - xi).norm(), 1e-12);
}

}  // namespace
}  // namespace pavo::test
