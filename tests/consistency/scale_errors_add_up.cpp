// ScaleError against the whole Kalman filter of position and scale, written out.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "stages/map/scale_error.h"

namespace pavo::test {
namespace {

using Joint = Eigen::Matrix4d;  // position, s

Joint joint_of(const ScaleError& e) {
  Joint J;
  J << e.position_variance, e.variance * e.lag, e.variance * e.lag.transpose(), e.variance;
  return J;
}

Joint left_alone(double gain) {
  Joint keep = Joint::Identity();
  keep(3, 3) = 1 - gain;
  return keep;
}

TEST(ScaleError, IsTheKalmanFilterOfPositionAndScale) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  ScaleError error;
  error.restart(0.3);
  Joint P = Joint::Zero();
  P(3, 3) = 0.3;
  for (int k = 0; k < 200; ++k) {
    const Eigen::Vector3d step(0.1 * uniform(random), 0.1 * uniform(random), 1 + 0.3 * uniform(random));
    error.travel(step);
    Joint F = Joint::Identity();
    F.topRightCorner<3, 1>() = step;
    P = (F * P * F.transpose()).eval();
    error.walk(1e-4);
    P(3, 3) += 1e-4;
    if (k % 3 == 0) {
      const double noise = 0.02 + 0.01 * uniform(random);
      const Eigen::Vector4d gain = P.col(3) / (P(3, 3) + noise);
      P = (left_alone(gain(3)) * P * left_alone(gain(3)).transpose()).eval(), P(3, 3) += gain(3) * gain(3) * noise;
      error.measured(error.variance * noise / (error.variance + noise));
    }
    ASSERT_TRUE(joint_of(error).isApprox(P, 1e-6)) << k << "\n" << joint_of(error) << "\n\n" << P;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(error.position_variance);
  EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-12);
}

TEST(ScaleError, BeforeAnythingIsMeasuredIsTheWholeWay) {
  ScaleError error;
  error.restart(1);
  for (int k = 0; k < 5; ++k) error.travel({0, 0, 2});
  EXPECT_TRUE(error.lag.isApprox(Eigen::Vector3d(0, 0, 10)));
  EXPECT_NEAR(error.position_variance(2, 2), 100, 1e-9);
  error.rescale(0.5);
  EXPECT_NEAR(error.position_variance(2, 2), 25, 1e-9);
  error.measured(0);
  EXPECT_NEAR(error.position_variance(2, 2), 25, 1e-9);  // what was published stays as wrong as it is
  error.travel({0, 0, 3});
  EXPECT_NEAR(error.position_variance(2, 2), 25, 1e-9);
}

}  // namespace
}  // namespace pavo::test
