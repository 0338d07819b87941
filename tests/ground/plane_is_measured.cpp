// The alignment on rendered roads: the plane, its uncertainty, and when there is none.
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "stages/ground/align_ground.h"
#include "tests/ground/roads.h"

namespace pavo {
namespace {

using roads::camera;
using roads::on_the_way;
using roads::Road;

struct Pair {
  GroundImage reference, current;
  SE3 T_ref_cur;
  Eigen::Vector3d m;  // the true one, per metre
};

Pair pair_of(const Road& road, const GroundAttitude& held, double step_m, double yaw_rad = 0) {
  const SE3 a = on_the_way(0, held), b = on_the_way(step_m, held, yaw_rad);
  Pair p;
  p.reference.assign(road.seen_from(a).view(), 70);
  p.current.assign(road.seen_from(b).view(), 70);
  p.T_ref_cur = a.inverse() * b;
  p.m = down_of(attitude_of(b.R.transpose() * Eigen::Vector3d::UnitY())) / road.height_m;
  return p;
}

GroundPrior prior_of(const Eigen::Vector3d& m, double length_sigma = 0.2, double angle_sigma = 0.03) {
  const double length = m.norm();
  Eigen::Matrix3d B;
  B.col(0) = m;
  B.rightCols<2>() = length * down_derivative(attitude_of(m));
  const Eigen::Vector3d sigma(length_sigma, angle_sigma, angle_sigma);
  return {m, (B * sigma.cwiseAbs2().asDiagonal() * B.transpose()).inverse()};
}

GroundMeasurement measure(const Pair& p, const Eigen::Vector3d& believed, const People& people = {}) {
  AlignGround align(camera(), {});
  return align(p.current, p.reference, p.T_ref_cur, prior_of(believed), people);
}

TEST(AlignGround, FindsThePlaneFromAWrongStart) {
  for (const double pitch : {-0.05, 0.0, 0.03})
    for (const double error : {0.88, 1.0, 1.12}) {
      SCOPED_TRACE(testing::Message() << "pitch " << pitch << ", start times " << error);
      const Pair p = pair_of({}, {pitch, 0.01}, 0.7);
      const GroundMeasurement found = measure(p, down_of({pitch + 0.01, 0}) * error / 1.5);
      ASSERT_TRUE(found.found);
      EXPECT_EQ(found.reason, GroundReason::seen);
      EXPECT_NEAR(found.m.norm() * 1.5, 1, 0.03);
      EXPECT_NEAR(attitude_of(found.m).pitch_rad, pitch, 0.01);
      EXPECT_NEAR(attitude_of(found.m).roll_rad, 0.01, 0.015);
    }
}

TEST(AlignGround, TurnsAndOtherUnitsMakeNoDifference) {
  Pair p = pair_of({}, {-0.02, 0}, 0.6, 0.03);
  p.T_ref_cur.t *= 5;  // five units a metre
  const GroundMeasurement found = measure(p, down_of({-0.02, 0}) / (5 * 1.5) * 1.05);
  ASSERT_TRUE(found.found);
  EXPECT_NEAR(found.m.norm() * 5 * 1.5, 1, 0.03);
}

TEST(AlignGround, ARobotNearTheGroundSeesItToo) {
  Road road;
  road.height_m = 0.25, road.grain_m = 0.02;
  const Pair p = pair_of(road, {-0.02, 0}, 0.1);
  const GroundMeasurement found = measure(p, down_of({0, 0}) / 0.25 * 1.1);
  ASSERT_TRUE(found.found);
  EXPECT_NEAR(found.m.norm() * 0.25, 1, 0.04);
}

TEST(AlignGround, UncertaintyCoversTheErrors) {
  double squared = 0;
  int count = 0;
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    Road road;
    road.seed = seed;
    const Pair p = pair_of(road, {-0.03, 0}, 0.7);
    const GroundMeasurement found = measure(p, down_of({-0.03, 0}) / 1.5 * 1.05);
    ASSERT_TRUE(found.found);
    // With the attitude known, as sigma means it.
    const Eigen::Vector3d theirs = found.m + found.information.inverse() * found.pull;
    const Eigen::Vector3d error = theirs - p.m;
    squared += error.dot(found.information * error);
    ++count;
  }
  EXPECT_LT(squared / (3 * count), 2) << "overconfident";
}

// What a block says is the true difference: J as computed, against pictures rendered with that difference.
TEST(AlignGround, DerivativesAreThoseOfThePictures) {
  const Pair p = pair_of({}, {-0.03, 0}, 0.7);
  AlignGroundOptions options;
  options.rotation_sigma_rad = options.direction_sigma = options.curvature = 1e-9;  // nothing is moved but looked at
  const auto shifts = [&](const Eigen::Vector3d& m, const SE3& T) {
    AlignGround align(camera(), options);
    align(p.current, p.reference, T, prior_of(m, 1e-7, 1e-7), {});
    return align.blocks();
  };
  const Eigen::Vector3d off = p.m * 0.004;
  SE3 turned = p.T_ref_cur;
  const Eigen::Vector3d turn(3e-4, 0, 0);
  turned.R = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * turned.R;
  const auto plain = shifts(p.m, p.T_ref_cur), moved = shifts(p.m - off, p.T_ref_cur), rotated = shifts(p.m, turned);
  ASSERT_EQ(plain.size(), moved.size());
  ASSERT_EQ(plain.size(), rotated.size());
  ASSERT_GT(plain.size(), 20u);
  double plane_said = 0, plane_meant = 0, turn_said = 0, turn_meant = 0;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const double weight = plain[i].information;
    plane_said += weight * (moved[i].shift - plain[i].shift) * off.dot(plain[i].ray);
    plane_meant += weight * off.dot(plain[i].ray) * off.dot(plain[i].ray);
    const double by_turn = -plain[i].nuisance.head<3>().dot(turn);
    turn_said += weight * (rotated[i].shift - plain[i].shift) * by_turn;
    turn_meant += weight * by_turn * by_turn;
  }
  EXPECT_NEAR(plane_said / plane_meant, 1, 0.2);
  EXPECT_NEAR(turn_said / turn_meant, 1, 0.2);
}

TEST(AlignGround, WhatMovesAlongWithTheCameraIsLeftOut) {
  const SE3 a = on_the_way(0), b = on_the_way(0.7);
  Image before = Road{}.seen_from(a), after = Road{}.seen_from(b);
  Pair p = pair_of({}, {}, 0.7);
  for (int y = 90; y < 180; ++y)  // somebody's back, a metre ahead all the time, over a third of the strip
    for (int x = 200; x < 250; ++x) {
      const double value = 120 + 90 * (roads::texture(x / 5.0, y / 5.0, 99) - 0.5);
      before.at(x, y) = after.at(x, y) = static_cast<std::uint8_t>(value);
    }
  p.reference.assign(before.view(), 70);
  p.current.assign(after.view(), 70);
  const GroundMeasurement found = measure(p, down_of({0, 0}) / 1.5 * 1.05);
  ASSERT_TRUE(found.found);
  EXPECT_NEAR(found.m.norm() * 1.5, 1, 0.03);
}

TEST(AlignGround, SeesNoGroundWhereThereIsNone) {
  const Pair road = pair_of({}, {}, 0.7);
  const Eigen::Vector3d believed = down_of({0, 0}) / 1.5;
  Pair p = road;

  Image blank(camera().width, camera().height);
  for (int y = 0; y < blank.height(); ++y) std::fill_n(blank.row(y), blank.width(), std::uint8_t{80});
  p.reference.assign(blank.view(), 70);
  p.current.assign(blank.view(), 70);
  EXPECT_FALSE(measure(p, believed).found) << "blank";

  Image night(blank.width(), blank.height()), later(blank.width(), blank.height());
  for (int y = 0; y < blank.height(); ++y)
    for (int x = 0; x < blank.width(); ++x) {
      night.at(x, y) = static_cast<std::uint8_t>(8 + 6 * roads::texture(x, y, 3));
      later.at(x, y) = static_cast<std::uint8_t>(8 + 6 * roads::texture(x, y, 4));
    }
  p.reference.assign(night.view(), 70);
  p.current.assign(later.view(), 70);
  EXPECT_FALSE(measure(p, believed).found) << "night: noise that does not repeat";

  p = road;
  const People crowd{{0, 0, 480, 180, 1}};
  const GroundMeasurement hidden = measure(p, believed, crowd);
  EXPECT_FALSE(hidden.found);
  EXPECT_EQ(hidden.reason, GroundReason::too_few_blocks);

  p.T_ref_cur.t.setZero();
  EXPECT_EQ(measure(p, believed).reason, GroundReason::no_motion);
}

TEST(AlignGround, AWallIsNoGround) {
  const Camera c = camera();
  const auto wall = [&](double distance) {
    Image image(c.width, c.height);
    for (int y = 0; y < c.height; ++y)
      for (int x = 0; x < c.width; ++x) {
        const double u = (x - c.cx) / c.fx * distance, v = (y - c.cy) / c.fy * distance;
        image.at(x, y) = static_cast<std::uint8_t>(60 + 120 * roads::texture(u / 0.1, v / 0.1, 5));
      }
    return image;
  };
  Pair p = pair_of({}, {}, 0.7);
  p.reference.assign(wall(6).view(), 70);
  p.current.assign(wall(5.3).view(), 70);
  const GroundMeasurement seen = measure(p, down_of({0, 0}) / 1.5);
  EXPECT_FALSE(seen.found) << "agreed " << seen.agreed << " of " << seen.asked << ", sigma " << seen.sigma;
}

}  // namespace
}  // namespace pavo
