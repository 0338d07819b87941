// Our bundle adjustment against Ceres on the same problem: other parameters, automatic derivatives, the same minimum.
#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include "tests/keyframe/street_of_points.h"

namespace pavo::test {
namespace {

// A pose is (rotation vector, position), a point its coordinates.
struct Reprojection {
  double x, y, inverse_sigma;

  template <class T>
  bool operator()(const T* pose, const T* point, T* residual) const {
    const T moved[3] = {point[0] - pose[3], point[1] - pose[4], point[2] - pose[5]};
    const T back[3] = {-pose[0], -pose[1], -pose[2]};
    T p[3];
    ceres::AngleAxisRotatePoint(back, moved, p);
    residual[0] = (kCamera.fx * p[0] / p[2] + kCamera.cx - x) * inverse_sigma;
    residual[1] = (kCamera.fy * p[1] / p[2] + kCamera.cy - y) * inverse_sigma;
    return true;
  }
};

struct Solution {
  std::vector<std::array<double, 6>> poses;
  std::vector<Eigen::Vector3d> points;
  double cost = 0;
};

Solution by_ceres(const Bundle& bundle, double loss_scale) {
  Solution s;
  for (const BundlePose& pose : bundle.poses) {
    const Eigen::Vector3d w = rotation_vector(pose.T_w_c.R), t = pose.T_w_c.t;
    s.poses.push_back({w.x(), w.y(), w.z(), t.x(), t.y(), t.z()});
  }
  for (const BundlePoint& point : bundle.points)
    s.points.push_back(point.ray.origin + point.ray.direction / point.ray.rho);
  ceres::Problem problem;
  for (const BundleObservation& z : bundle.observations)
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Reprojection, 2, 6, 3>(new Reprojection{z.x, z.y, z.inverse_sigma}),
        new ceres::CauchyLoss(loss_scale), s.poses[z.pose].data(), s.points[z.point].data());
  for (std::size_t i = 0; i < bundle.poses.size(); ++i)
    if (bundle.poses[i].fixed) problem.SetParameterBlockConstant(s.poses[i].data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = 100;
  options.function_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  s.cost = 2 * summary.final_cost;
  return s;
}

class AgainstCeres : public ::testing::TestWithParam<double> {};

TEST_P(AgainstCeres, TheMinimumIsTheSame) {
  StreetOfPoints street = street_of_points(3, 7, 60, 0.4, GetParam());
  BundleOptions options;
  options.iterations = 300;  // the narrower the loss, the slower do weights settle
  options.least_gain = 1e-15;
  const Solution ceres = by_ceres(street.bundle, options.loss_scale);
  BundleAdjustment adjust(kCamera, options);
  const BundleSummary summary = adjust(street.bundle);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  EXPECT_NEAR(summary.final_cost, ceres.cost, 1e-5 * ceres.cost);
  for (std::size_t i = 0; i < street.bundle.poses.size(); ++i) {
    const SE3& T = street.bundle.poses[i].T_w_c;
    const std::array<double, 6>& c = ceres.poses[i];
    EXPECT_LT((T.t - Eigen::Vector3d(c[3], c[4], c[5])).norm(), 2e-5) << i;
    EXPECT_LT((rotation_vector(T.R) - Eigen::Vector3d(c[0], c[1], c[2])).norm(), 2e-6) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Outliers, AgainstCeres, ::testing::Values(0.0, 0.1));

}  // namespace
}  // namespace pavo::test
