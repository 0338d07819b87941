// The filter, and the whole of it on rendered drives.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "stages/ground/ground_scale.h"
#include "tests/ground/roads.h"

namespace pavo {
namespace {

using roads::camera;
using roads::on_the_way;
using roads::Road;

GroundMeasurement look_of(double metres_per_unit, double height, const GroundAttitude& held, double sigma) {
  GroundMeasurement look;
  look.found = true;
  look.m = down_of(held) * metres_per_unit / height;
  Eigen::Matrix3d B;
  B.col(0) = look.m;
  B.rightCols<2>() = look.m.norm() * down_derivative(held);
  look.information = (B * Eigen::Vector3d(sigma * sigma, 1e-6, 1e-6).asDiagonal() * B.transpose()).inverse();
  look.slope = 0.2;
  return look;
}

ScaleFilterOptions filter_options() {
  ScaleFilterOptions options;
  options.height_m = 1.5;
  return options;
}

TEST(ScaleFilter, ConvergesAndHolds) {
  ScaleFilter filter(filter_options());
  EXPECT_FALSE(filter.known());
  filter.assume(0.9, 0.1);
  for (int i = 0; i < 60; ++i) {
    filter.predict(1e-3);
    EXPECT_TRUE(filter.update(look_of(0.8, 1.5, {-0.02, 0.01}, 0.02)));
  }
  EXPECT_NEAR(filter.metres_per_unit(), 0.8, 0.008);
  EXPECT_NEAR(filter.attitude().pitch_rad, -0.02, 0.004);
  const double sure = filter.sigma(), scale = filter.metres_per_unit();
  for (int i = 0; i < 20; ++i) {  // no ground to see
    filter.predict(1e-3);
    EXPECT_FALSE(filter.update(GroundMeasurement{}));
  }
  EXPECT_EQ(filter.metres_per_unit(), scale) << "it holds";
  EXPECT_GT(filter.sigma(), sure) << "and is less sure";
}

/// Along ground to which the camera is held so, at an angle to its axis.
Eigen::Vector3d along_ground(const GroundAttitude& held, double heading, double off_ground) {
  const Eigen::Vector3d down = down_of(held), ahead = down.cross(Eigen::Vector3d::UnitX()).normalized() * -1;
  const Eigen::Vector3d right = down.cross(ahead);
  const Eigen::Vector3d way = std::cos(heading) * ahead + std::sin(heading) * right + off_ground * down;
  return way.normalized();
}

TEST(ScaleFilter, LearnsFromTheWayHowTheCameraIsHeld) {
  const GroundAttitude held{.pitch_rad = -0.03, .roll_rad = 0.02};
  ASSERT_GT(along_ground(held, 0, 0).z(), 0.99);
  ASSERT_NEAR(along_ground(held, 0.7, 0).dot(down_of(held)), 0, 1e-12);
  std::mt19937 random(5);
  std::normal_distribution<double> hump(0, 0.005);
  ScaleFilter ahead(filter_options()), about(filter_options());
  for (int i = 0; i < 60; ++i) {
    EXPECT_TRUE(ahead.travelled(along_ground(held, 0, hump(random))));
    EXPECT_TRUE(about.travelled(along_ground(held, i % 2 ? 1 : -1, hump(random))));
  }
  EXPECT_FALSE(ahead.known()) << "a direction has no length";
  EXPECT_NEAR(ahead.attitude().pitch_rad, held.pitch_rad, 0.004);
  EXPECT_NEAR(ahead.attitude().roll_rad, 0, 1e-3) << "straight ahead tells nothing of it";
  EXPECT_NEAR(about.attitude().pitch_rad, held.pitch_rad, 0.006);
  EXPECT_NEAR(about.attitude().roll_rad, held.roll_rad, 0.006);
}

TEST(ScaleFilter, HoldsTheScaleWhereOnlyTheWayIsSeen) {
  ScaleFilter filter(filter_options());
  filter.assume(1, 0.1);
  for (int i = 0; i < 5; ++i) filter.update(look_of(0.97, 1.5, {}, 0.02));
  const double scale = filter.metres_per_unit(), sure = filter.sigma();
  for (int i = 0; i < 20; ++i) {
    filter.predict(1e-3);
    EXPECT_TRUE(filter.travelled(along_ground({.pitch_rad = -0.015}, 0, 0)));
  }
  EXPECT_EQ(filter.metres_per_unit(), scale);
  EXPECT_GE(filter.sigma(), sure);
  EXPECT_NEAR(filter.attitude().pitch_rad, -0.015, 0.005);
  // The next look says the same as the first ones. All of them saw ground that tilts by 0.015 rad and so, from the
  // lever on, another height than that below the camera.
  filter.update(look_of(0.97, 1.5, {}, 0.02));
  EXPECT_NEAR(filter.metres_per_unit(), 0.97 * std::exp(-0.015 * filter_options().lever / 0.2), 0.01);
}

TEST(ScaleFilter, LeavesOutAWayThatIsNotAlongTheGround) {
  ScaleFilter filter(filter_options());
  for (int i = 0; i < 20; ++i) filter.travelled(along_ground({}, 0, 0));
  const Eigen::Matrix3d before = filter.covariance();
  EXPECT_FALSE(filter.travelled(along_ground({}, 0, 0.3)));  // a lift
  EXPECT_EQ(filter.attitude().pitch_rad, 0);
  EXPECT_EQ(filter.covariance(), before);
}

// A start between people, whose ways all point down a slope that is not there. What comes after must be heard, though
// the first ways made the filter sure of themselves.
TEST(ScaleFilter, DoubtsTheAttitudeOfAWrongStart) {
  ScaleFilter filter(filter_options());
  filter.assume(1, 0.1);
  for (int i = 0; i < 8; ++i) {
    filter.predict(1e-3);
    EXPECT_TRUE(filter.travelled(along_ground({.pitch_rad = -0.056}, 0, 0)));
    EXPECT_TRUE(filter.update(look_of(0.8, 1.5, {-0.043, 0}, 0.02)));
  }
  EXPECT_LT(filter.attitude().pitch_rad, -0.05);
  EXPECT_FALSE(filter.travelled(along_ground({.pitch_rad = -0.01}, 0, 0))) << "one may be a hump";
  for (int i = 0; i < 25; ++i) {
    filter.predict(1e-3);
    filter.travelled(along_ground({.pitch_rad = -0.01}, 0, 0));
  }
  EXPECT_NEAR(filter.attitude().pitch_rad, -0.01, 0.006);
}

// The look is at ground that falls ahead: with the pitch from the way, height is that of where the camera is.
TEST(ScaleFilter, TakesTheHeightFromALookAtTheMountingsPitch) {
  ScaleFilter with(filter_options()), without(filter_options());
  const GroundMeasurement look = look_of(0.96, 1.5, {-0.012, 0}, 0.01);
  for (ScaleFilter* filter : {&with, &without}) {
    filter->assume(1, 0.1);
    for (int i = 0; i < 40; ++i) {
      filter->predict(1e-3);
      if (filter == &with) filter->travelled(along_ground({}, 0, 0));
      EXPECT_TRUE(filter->update(look));
    }
  }
  EXPECT_NEAR(without.metres_per_unit(), 0.96, 0.005);
  EXPECT_NEAR(with.attitude().pitch_rad, 0, 0.004);
  EXPECT_GT(with.metres_per_unit(), 0.98);
}

TEST(ScaleFilter, LeavesOutWhatDoesNotFitUntilItIsLost) {
  ScaleFilter filter(filter_options());
  filter.assume(1, 0.05);
  for (int i = 0; i < 40; ++i) filter.update(look_of(1, 1.5, {}, 0.02));
  const double before = filter.metres_per_unit();
  EXPECT_FALSE(filter.update(look_of(1.6, 1.5, {}, 0.02)));
  EXPECT_EQ(filter.metres_per_unit(), before);
  for (int i = 0; i < 30 && filter.known(); ++i) filter.update(look_of(1.6, 1.5, {}, 0.02));
  EXPECT_FALSE(filter.known()) << "many in a row: what was known was wrong";
}

TEST(ScaleFilter, OtherUnitsAndOtherSensors) {
  ScaleFilter filter(filter_options());
  filter.assume(1, 0.05);
  filter.rescale(2);  // two new units where one was
  EXPECT_NEAR(filter.metres_per_unit(), 0.5, 1e-12);
  EXPECT_TRUE(filter.update(0.52, 0.01));
  EXPECT_GT(filter.metres_per_unit(), 0.515);
  EXPECT_FALSE(filter.update(2, 0.01)) << "out of the gate";
  EXPECT_FALSE(filter.update(-1, 0.01));
  filter.restart();
  EXPECT_FALSE(filter.known());
  EXPECT_THROW(ScaleFilter({.height_m = 0}), std::invalid_argument);
  EXPECT_THROW(ScaleFilter({.height_m = std::numeric_limits<double>::quiet_NaN()}), std::invalid_argument);
}

TEST(ScaleFilter, ErrorsAreWhatItSays) {
  double squared = 0;
  constexpr int kRuns = 60, kTimes = 3;  // the same ground is seen
  for (int run = 0; run < kRuns; ++run) {
    std::mt19937 random(static_cast<std::uint32_t>(run));
    std::normal_distribution<double> normal;
    const ScaleFilterOptions options = filter_options();
    ScaleFilter filter(options);
    filter.assume(std::exp(0.1 * normal(random)), 0.1);
    for (int i = 0; i < 40; ++i) {
      const double tilt = options.slope_sigma * normal(random);
      const double error = 0.01 * normal(random) + options.height_sigma * normal(random) + options.lever / 0.2 * tilt;
      for (int again = 0; again < kTimes; ++again) {
        filter.predict(0);
        filter.update(look_of(std::exp(error), 1.5, {tilt, 0}, 0.01));
      }
    }
    squared += std::pow(std::log(filter.metres_per_unit()) / filter.sigma(), 2);
  }
  EXPECT_LT(squared / kRuns, 1.5) << "overconfident";
  EXPECT_GT(squared / kRuns, 0.5) << "too cautious";
}

GroundScaleOptions scale_options() {
  GroundScaleOptions options;
  options.filter.height_m = 1.5;
  return options;
}

// A drive of `frames` steps of `step_m`, mapped in a unit of its own, in which it begins at `from`. Returns how many
// looks were used.
int drive(GroundScale& scale, double units_per_metre, int first, int frames, double step_m, const GroundAttitude& held,
          const People& people = {}, const Eigen::Vector3d& from = Eigen::Vector3d::Zero()) {
  int used = 0;
  for (int i = first; i < first + frames; ++i) {
    const Image image = Road{}.seen_from(on_the_way(i * step_m, held));
    SE3 T = on_the_way(0, held).inverse() * on_the_way(i * step_m, held);
    T.t = from + units_per_metre * T.t;
    used += scale.observe(i, image.view(), T, people).used;
  }
  return used;
}

TEST(GroundScale, FindsTheUnitOfAMapByItself) {
  for (const double units_per_metre : {0.2, 1.0, 7.0}) {
    SCOPED_TRACE(units_per_metre);
    GroundScale scale(camera(), scale_options());
    drive(scale, units_per_metre, 0, 8, 0.6, {-0.03, 0.01});
    ASSERT_TRUE(scale.known());
    EXPECT_NEAR(scale.metres_per_unit() * units_per_metre, 1, 0.035);
    EXPECT_NEAR(scale.attitude().pitch_rad, -0.03, 0.01);
    EXPECT_LT(scale.sigma(), 0.05);
  }
}

// People who go along: in each stripe of the picture everything moves at a pace of its own, up to the road's, and so
// fits the plane at a scale of its own.
Image between_people(double way_m) {
  constexpr int kPaces = 4, kStripe = 40;
  Image image(camera().width, camera().height);
  for (int pace = 0; pace < kPaces; ++pace) {
    const Image at_pace = Road{}.seen_from(on_the_way(way_m * std::pow(0.7, pace)));
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x)
        if (x / kStripe % kPaces == pace) image.at(x, y) = at_pace.at(x, y);
  }
  return image;
}

TEST(GroundScale, WaitsInACrowdWhileManyScalesFit) {
  const People five(5, {10, 0, 20, 20, 1});  // over the horizon: they hide nothing
  const auto starts_with = [](const People& people) {
    GroundScale scale(camera(), scale_options());
    for (int i = 0; i < 6; ++i) scale.observe(i, between_people(0.6 * i).view(), on_the_way(0.6 * i), people);
    return scale.known();
  };
  EXPECT_TRUE(starts_with({}));
  EXPECT_FALSE(starts_with(five));
}

// The pictures are of the road, and the motion that is given with them leads up from it. That goes on for so long that
// the filter doubts itself, and would then take what it is told.
TEST(GroundScale, LearnsNothingFromAMotionThatIsNotAlongTheGround) {
  GroundScale scale(camera(), scale_options());
  drive(scale, 1, 0, 12, 0.6, {});
  const double metres_per_unit = scale.metres_per_unit();
  for (int i = 12; i < 21; ++i) {
    SE3 T = on_the_way(0.6 * i);
    T.t.y() -= 0.03 * 0.6 * (i - 11);
    const bool used = scale.observe(i, Road{}.seen_from(on_the_way(0.6 * i)).view(), T, {}).used;
    EXPECT_FALSE(used && scale.filter().ways_are_strange()) << i;
  }
  EXPECT_NEAR(scale.metres_per_unit(), metres_per_unit, 0.02);
  EXPECT_GE(drive(scale, 1, 21, 6, 0.6, {}, {}, {0, -0.03 * 0.6 * 9, 0}), 3) << "then it goes on";
}

// The nose goes down as the car brakes, and then it crawls, by less a frame than a direction can be told from.
TEST(GroundScale, LooksAgainWhenItIsSlowAfterStrangeWays) {
  GroundScale scale(camera(), scale_options());
  drive(scale, 1, 0, 12, 0.6, {});
  for (int i = 12; i < 23; ++i) {  // for so long that it would begin to compare a frame with the last one only
    SE3 T = on_the_way(0.6 * i);
    T.t.y() -= 0.1 * 0.6 * (i - 11);
    scale.observe(i, Road{}.seen_from(on_the_way(0.6 * i)).view(), T, {});
  }
  EXPECT_GE(drive(scale, 1, 40, 30, 0.3, {}), 10);
}

TEST(GroundScale, HoldsWherePeopleHideTheGround) {
  GroundScale scale(camera(), scale_options());
  drive(scale, 1, 0, 6, 0.6, {});
  const double before = scale.metres_per_unit();
  drive(scale, 1, 6, 4, 0.6, {}, {{0, 60, 480, 130, 1}});
  EXPECT_EQ(scale.metres_per_unit(), before);
}

TEST(GroundScale, FollowsAMapThatIsScaledOrMadeAnew) {
  GroundScale scale(camera(), scale_options());
  drive(scale, 1, 0, 6, 0.6, {});
  scale.rescale(3, Eigen::Vector3d::Zero());
  EXPECT_NEAR(scale.metres_per_unit() * 3, 1, 0.035);
  drive(scale, 3, 6, 3, 0.6, {});
  EXPECT_NEAR(scale.metres_per_unit() * 3, 1, 0.035);
  scale.restart();
  EXPECT_FALSE(scale.known());
  drive(scale, 0.5, 9, 6, 0.6, {});
  ASSERT_TRUE(scale.known());
  EXPECT_NEAR(scale.metres_per_unit() * 0.5, 1, 0.035);
}

// The map is scaled about its newest keyframe, which after a long drive is far from where it began.
TEST(GroundScale, FollowsAMapThatIsScaledFarFromItsOrigin) {
  constexpr double kFactor = 1.02;
  GroundScale scale(camera(), scale_options());
  const Eigen::Vector3d begin(0, 0, 300), newest = begin + Eigen::Vector3d(0, 0, 5 * 0.6);
  drive(scale, 1, 0, 6, 0.6, {}, {}, begin);
  scale.rescale(kFactor, newest);
  EXPECT_EQ(drive(scale, kFactor, 6, 3, 0.6, {}, {}, newest + kFactor * (begin - newest)), 3);
  EXPECT_NEAR(scale.metres_per_unit() * kFactor, 1, 0.035);
}

TEST(GroundScale, MeasuresSingleSteps) {
  GroundScale scale(camera(), scale_options());
  double position = 0, expected = 0;
  for (int i = 0; i < 7; ++i) {
    const double step = 0.6 + 0.02 * i;
    if (i > 0) position += step;
    const Image image = Road{}.seen_from(on_the_way(position));
    scale.remember(i, image.view());
    if (i == 0) continue;
    SE3 T;
    T.t = Eigen::Vector3d(0, 0, 1);
    scale.step(i, i - 1, T, expected, 0.1, {});
    if (scale.known()) expected = scale.metres_per_unit();
    if (i > 3) {
      EXPECT_NEAR(scale.metres_per_unit(), step, 0.05 * step) << i;
    }
  }
  EXPECT_TRUE(scale.known());
}

TEST(GroundScale, TheSameInputGivesTheSameBits) {
  GroundScale a(camera(), scale_options()), b(camera(), scale_options());
  drive(a, 1, 0, 5, 0.6, {});
  drive(b, 1, 0, 5, 0.6, {});
  EXPECT_EQ(a.metres_per_unit(), b.metres_per_unit());
  EXPECT_EQ(a.covariance(), b.covariance());
}

}  // namespace
}  // namespace pavo
