#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "stages/pose/motion_model.h"
#include "stages/pose/scale.h"
#include "tests/pose/scenes.h"

namespace pavo::test {
namespace {

constexpr std::int64_t kSecond = 1000000000;

Step step(std::int64_t from_ns, std::int64_t to_ns) {
  return {0, 0, 1, from_ns, from_ns, to_ns};
}

TEST(Scale, UnitIsOneForEveryFrameThatMoved) {
  const UnitStep unit;
  EXPECT_EQ(unit.metres({4, 4, 5, 0, 0, 1}), 1);
  EXPECT_EQ(unit.metres({4, 4, 7, 0, 0, 1}), 3);    // two frames lost
  EXPECT_EQ(unit.metres({4, 90, 91, 0, 0, 1}), 1);  // stood still from 4 to 90
  EXPECT_FALSE(unit.metric());
}

TEST(Scale, SpeedIsIntegratedBetweenItsSamples) {
  const SpeedStep speed({{0, 0}, {2 * kSecond, 4}, {3 * kSecond, 4}, {4 * kSecond, 0}});
  EXPECT_NEAR(speed.metres(step(0, 2 * kSecond)), 4, 1e-12);
  EXPECT_NEAR(speed.metres(step(0, kSecond)), 1, 1e-12);
  EXPECT_NEAR(speed.metres(step(kSecond, 2 * kSecond)), 3, 1e-12);
  EXPECT_NEAR(speed.metres(step(kSecond, 4 * kSecond)), 3 + 4 + 2, 1e-12);
  EXPECT_NEAR(speed.metres(step(2 * kSecond, 2 * kSecond)), 0, 1e-12);
  // Summing small steps gives the whole.
  double sum = 0;
  for (std::int64_t t = 0; t < 4 * kSecond; t += kSecond / 10) sum += speed.metres(step(t, t + kSecond / 10));
  EXPECT_NEAR(sum, 10, 1e-9);
}

TEST(Scale, SpeedIsUnknownFarFromItsSamples) {
  const SpeedStep speed({{0, 2}, {kSecond, 3}}, 0.5);
  EXPECT_NEAR(speed.metres(step(kSecond, kSecond + kSecond / 2)), 1.5, 1e-12);
  EXPECT_NEAR(speed.metres(step(-kSecond / 4, 0)), 0.5, 1e-12);
  EXPECT_TRUE(std::isnan(speed.metres(step(kSecond, 2 * kSecond))));
  EXPECT_TRUE(std::isnan(speed.metres(step(-kSecond, 0))));
}

TEST(Scale, BadSpeedsAreRefused) {
  EXPECT_THROW(SpeedStep({}), std::runtime_error);
  EXPECT_THROW(SpeedStep({{0, 1}, {0, 1}}), std::runtime_error);
  EXPECT_THROW(SpeedStep({{5, 1}, {4, 1}}), std::runtime_error);
  EXPECT_THROW(SpeedStep({{0, std::numeric_limits<double>::quiet_NaN()}}), std::runtime_error);
}

TEST(Scale, GroundtruthIsTheDistanceBetweenPositions) {
  const GroundtruthStep truth({{0, 0, 0}, {3, 4, 0}, {3, 4, std::nan("")}});
  EXPECT_EQ(truth.metres({0, 0, 1, 0, 0, 0}), 5);
  EXPECT_TRUE(std::isnan(truth.metres({1, 1, 2, 0, 0, 0})));
  EXPECT_TRUE(std::isnan(truth.metres({1, 1, 3, 0, 0, 0})));
  EXPECT_TRUE(std::isnan(truth.metres({-1, -1, 0, 0, 0, 0})));
}

TEST(MotionModel, RepeatsItsStepAndScalesItWithTime) {
  MotionModel model;
  const SE3 rest = model.predict({0, 0, 0}, {1, 100, 0});
  EXPECT_TRUE(rest.R.isIdentity(0) && rest.t.isZero(0));

  const SE3 observed = driving().inverse();
  model.observe(observed, {3, 300, 0}, {4, 400, 0});
  EXPECT_TRUE(model.predict({4, 400, 0}, {5, 500, 0}).R.isApprox(observed.R, 1e-12));
  const SE3 half = model.predict({4, 400, 0}, {5, 450, 0});
  EXPECT_TRUE((half.R * half.R).isApprox(observed.R, 1e-12));
  EXPECT_TRUE((2 * half.t).isApprox(observed.t, 1e-12));
  const SE3 twice = model.predict({4, 400, 0}, {7, 600, 2});
  EXPECT_TRUE(twice.R.isApprox(observed.R * observed.R, 1e-12));
}

TEST(MotionModel, CountsFramesWhereTimesAreUseless) {
  MotionModel model;
  model.observe(driving(), {3, 300, 0}, {4, 300, 0});
  EXPECT_TRUE(model.predict({4, 300, 0}, {6, 200, 1}).t.isApprox(2 * driving().t, 1e-12));
  model.observe(driving(), {3, 0, 0}, {4, 1, 0});
  EXPECT_TRUE(model.predict({4, 1, 0}, {5, std::numeric_limits<std::int64_t>::max() / 2, 0}).t.allFinite());
  EXPECT_LT(model.predict({4, 1, 0}, {5, std::numeric_limits<std::int64_t>::max() / 2, 0}).t.norm(), 100);
}

}  // namespace
}  // namespace pavo::test
