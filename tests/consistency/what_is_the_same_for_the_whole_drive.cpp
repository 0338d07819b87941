// SystematicErrors, alone: how much a straight way adds to each of the six.
#include <gtest/gtest.h>

#include <cmath>

#include "stages/keyframe/pose_uncertainty.h"

namespace pavo::test {
namespace {

constexpr double kFocal = 500;

Matrix6d after_straight(double metres, const SystematicErrors& errors) {
  PoseUncertainty uncertainty(errors, kFocal);
  SE3 from, to;
  for (int k = 0; k < 1000; ++k, from = to) {
    to.t.z() += metres / 1000;
    uncertainty.step(from, to, Matrix6d::Zero(), Matrix6d::Zero());
  }
  return uncertainty.covariance(to);
}

// Fully correlated: it grows with the way, not with its root. What turns the camera also takes it aside, by half of the
// way's square.
TEST(SystematicErrors, GrowWithTheWay) {
  const SystematicErrors errors{.log_scale = 0.01, .turn_px_per_m = 0.004, .pitch_px_per_m = 0.007, .direction_px = 0};
  for (const double metres : {1.0, 40.0}) {
    const Matrix6d C = after_straight(metres, errors);
    const double turn = 0.004 / kFocal * metres, pitch = 0.007 / kFocal * metres;
    EXPECT_NEAR(std::sqrt(C(3, 3)), pitch, 1e-3 * pitch);
    EXPECT_NEAR(std::sqrt(C(4, 4)), turn, 1e-3 * turn);
    EXPECT_NEAR(std::sqrt(C(5, 5)), turn, 1e-3 * turn);
    EXPECT_NEAR(std::sqrt(C(0, 0)), turn * metres / 2, 2e-3 * turn * metres);
    EXPECT_NEAR(std::sqrt(C(1, 1)), pitch * metres / 2, 2e-3 * pitch * metres);
    EXPECT_NEAR(std::sqrt(C(2, 2)), 0.01 * metres, 1e-3 * metres * 0.01);
  }
}

TEST(SystematicErrors, OfTheDirectionAreOnEachSide) {
  const SystematicErrors errors{.turn_px_per_m = 0, .pitch_px_per_m = 0, .direction_px = 0.1};
  const Matrix6d C = after_straight(20, errors);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(std::sqrt(C(i, i)), 20 * 0.1 / kFocal, 1e-6) << i;
  EXPECT_EQ((C.bottomRightCorner<3, 3>().norm()), 0);
}

}  // namespace
}  // namespace pavo::test
