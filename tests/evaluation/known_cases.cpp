// Cases whose every figure can be written down beforehand.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "tests/evaluation/paths.h"

namespace pavo {
namespace {

using namespace test;
constexpr double kDegree = std::numbers::pi / 180;

TEST(KnownCases, APerfectEstimateHasNoError) {
  const Trajectory truth = wandering(300, 1);
  const Evaluation e = evaluate(truth, truth);
  for (const Alignment a : {Alignment::none, Alignment::scale, Alignment::se3, Alignment::sim3})
    EXPECT_NEAR(e.aligned(a).ate_m.max, 0, 1e-10);
  EXPECT_NEAR(e.sim3.similarity.scale, 1, 1e-12);
  EXPECT_EQ(e.raw.poses.maxCoeff(), 0);
  EXPECT_EQ(e.raw.motions.maxCoeff(), 0);
  ASSERT_TRUE(e.raw.segments.all);
  EXPECT_NEAR(e.raw.segments.all->t_rel_percent, 0, 1e-10);
  EXPECT_NEAR(e.raw.segments.all->r_rel_deg_per_100m, 0, 1e-10);
  EXPECT_NEAR(e.raw.rpe.translation_m.max, 0, 1e-12);
}

TEST(KnownCases, APureScaleIsFoundAndTakenAway) {
  const Trajectory truth = straight(301);
  const Evaluation e = evaluate(straight(301, 1.25), truth);
  EXPECT_NEAR(e.sim3.similarity.scale, 0.8, 1e-12);
  EXPECT_NEAR(e.scale.similarity.scale, 0.8, 1e-12);
  EXPECT_NEAR(e.sim3.ate_m.rmse, 0, 1e-10);
  EXPECT_NEAR(e.scale.ate_m.rmse, 0, 1e-10);
  EXPECT_NEAR(e.none.ate_m.max, 75, 1e-10);  // 300 m, a quarter too far
  EXPECT_NEAR(e.none.ate_m.mean, 37.5, 1e-10);
  EXPECT_NEAR(e.none.ate_m.median, 37.5, 1e-10);
  EXPECT_NEAR(e.none.ate_m.rmse, 0.25 * std::sqrt(300.0 * 601 / 6), 1e-10);        // sum of squares 0..300
  EXPECT_NEAR(e.se3.ate_m.rmse, 0.25 * std::sqrt((301.0 * 301 - 1) / 12), 1e-10);  // about the middle
  // A segment ends at the first frame beyond its length: 101 and 201 motions, each 0.25 m off.
  EXPECT_NEAR(e.raw.segments.lengths[0].errors->t_rel_percent, 25.25, 1e-10);
  EXPECT_NEAR(e.raw.segments.lengths[1].errors->t_rel_percent, 201 * 0.25 / 2, 1e-10);
  EXPECT_NEAR(e.scaled->segments.all->t_rel_percent, 0, 1e-10);
  EXPECT_NEAR(e.raw.rpe.translation_m.rmse, 0.25, 1e-12);
  EXPECT_NEAR(e.scaled->rpe.translation_m.max, 0, 1e-12);
  EXPECT_NEAR(e.raw.motions(2, 3), 0.25, 1e-12);
  EXPECT_NEAR(e.raw.poses(2, 3), 0.25 * std::sqrt(300.0 * 601 / 6), 1e-10);
  EXPECT_NEAR(e.scaled->poses(2, 3), 0, 1e-10);
}

TEST(KnownCases, APureRotationOfTheWholeIsAlignedAway) {
  const Trajectory truth = wandering(200, 2);
  Similarity turn;
  turn.R = Eigen::AngleAxisd(2.0, Eigen::Vector3d(1, 2, -3).normalized()).toRotationMatrix();
  turn.t = {100, -20, 3};
  const Evaluation e = evaluate(moved(turn, truth), truth);
  for (const Alignment a : {Alignment::none, Alignment::scale, Alignment::se3, Alignment::sim3}) {
    EXPECT_NEAR(e.aligned(a).ate_m.max, 0, 1e-9) << "the first poses coincide, so every alignment finds it";
    EXPECT_TRUE(e.aligned(a).similarity.R.isApprox(turn.R.transpose(), 1e-9));
  }
  EXPECT_NEAR(e.raw.poses.maxCoeff(), 0, 1e-9);
  EXPECT_NEAR(e.raw.segments.all->t_rel_percent, 0, 1e-9);
}

TEST(KnownCases, ARotationOnTheSpotHasNoSegmentsAndNoScale) {
  const Evaluation e =
      evaluate(repeated({about_y(0.5 * kDegree), {0, 0, 0}}, 50), repeated({about_y(0.4 * kDegree), {0, 0, 0}}, 50));
  EXPECT_FALSE(e.raw.segments.all);
  EXPECT_FALSE(e.scaled);
  EXPECT_FALSE(e.sim3.similarity.scale_known);
  EXPECT_EQ(e.sim3.ate_m.max, 0);
  EXPECT_NEAR(e.raw.rpe.rotation_deg.mean, 0.1, 1e-12);
  EXPECT_NEAR(e.raw.rpe.rotation_deg.max, 0.1, 1e-12);
  EXPECT_NEAR(e.raw.motions(0, 0), std::cos(0.4 * kDegree) - std::cos(0.5 * kDegree), 1e-13);
  EXPECT_NEAR(e.raw.motions(0, 2), std::sin(0.5 * kDegree) - std::sin(0.4 * kDegree), 1e-13);
  EXPECT_EQ(e.raw.motions(1, 1), 0);
}

TEST(KnownCases, AKnownDriftOfDirectionIsAsManyDegreesAHundredMetres) {
  // Every frame turns 0.01 degrees too far.
  const Trajectory truth = straight(1001);
  const Evaluation e = evaluate(repeated({about_y(0.01 * kDegree), {0, 0, 1}}, 1001), truth, {.step = 1});
  ASSERT_EQ(e.raw.segments.lengths.size(), 8u);
  for (const auto& length : e.raw.segments.lengths) {
    ASSERT_TRUE(length.errors);
    const double frames = length.length_m + 1;
    EXPECT_NEAR(length.errors->r_rel_deg_per_100m, 0.01 * frames / length.length_m * 100, 1e-9);
    EXPECT_EQ(length.errors->segments, 1001 - static_cast<std::size_t>(frames));
    // Of a chain of n unit steps, each turned by a: the end is sin(n a/2) / sin(a/2) away, at (n-1) a/2. The estimate's
    // last frame sees the difference to n steps ahead.
    const double a = 0.01 * kDegree, chord = std::sin(frames * a / 2) / std::sin(a / 2), angle = (frames - 1) * a / 2;
    const double error = std::hypot(chord * std::cos(angle) - frames, chord * std::sin(angle));
    EXPECT_NEAR(length.errors->t_rel_percent, 100 * error / length.length_m, 1e-9);
  }
  EXPECT_NEAR(e.raw.rpe.rotation_deg.rmse, 0.01, 1e-12);
  EXPECT_NEAR(e.raw.rpe.translation_m.max, 0, 1e-12);
}

TEST(KnownCases, ABiasOfTranslationStaysInItsParameter) {
  // 2 cm to the right in every frame.
  const Evaluation e = evaluate(repeated({Eigen::Matrix3d::Identity(), {0.02, 0, 1}}, 201), straight(201));
  EXPECT_NEAR(e.raw.motions(0, 3), 0.02, 1e-12);
  EXPECT_NEAR(e.raw.motions.bottomRows(2).maxCoeff(), 0, 1e-12);
  EXPECT_NEAR(e.raw.poses(0, 3), 0.02 * std::sqrt(200.0 * 401 / 6), 1e-10);
  EXPECT_NEAR(e.raw.rpe.translation_m.median, 0.02, 1e-12);
  EXPECT_NEAR(e.raw.rpe.rotation_deg.max, 0, 1e-12);
  EXPECT_NEAR(e.raw.segments.all->t_rel_percent, 2.02, 1e-10);
  EXPECT_NEAR(e.sim3.ate_m.rmse, 0, 1e-9) << "a straight line is a straight line";
  EXPECT_NEAR(e.sim3.similarity.scale, 1 / std::hypot(0.02, 1.0), 1e-12);
}

TEST(KnownCases, SegmentsBeginAtEveryTenthFrameAndEndBeyondTheirLength) {
  // 100 m need 101 motions: of 111 poses, the frames 0, ..., 9 have that many behind them.
  EXPECT_EQ(evaluate(straight(111), straight(111)).raw.segments.all->segments, 1u);
  EXPECT_EQ(evaluate(straight(112), straight(112)).raw.segments.all->segments, 2u);
  EXPECT_EQ(evaluate(straight(111), straight(111), {.step = 1}).raw.segments.all->segments, 10u);
  EXPECT_FALSE(evaluate(straight(101), straight(101)).raw.segments.all) << "exactly 100 m is not more than 100 m";
}

TEST(KnownCases, ShortSequencesHaveShortSegments) {
  EXPECT_THAT(segment_lengths_m(99.9), ::testing::ElementsAre(10, 20, 30, 40, 50));
  EXPECT_THAT(segment_lengths_m(100), ::testing::ElementsAre(100, 200, 300, 400, 500, 600, 700, 800));
  const Evaluation e = evaluate(straight(61, 1.1), straight(61));
  ASSERT_TRUE(e.raw.segments.all);
  EXPECT_EQ(e.raw.segments.lengths[4].length_m, 50);
  EXPECT_NEAR(e.raw.segments.lengths[4].errors->t_rel_percent, 51 * 0.1 / 50 * 100, 1e-9);
}

TEST(KnownCases, StandingStillGivesNumbersOrNothingButNeverNaN) {
  const Trajectory still = repeated({}, 25);
  Trajectory far = still;
  for (SE3& pose : far.T_w_c) pose.t = {1e6 / 3, -7, 0.1};
  for (const auto& [estimate, truth] : std::vector<std::pair<Trajectory, Trajectory>>{{still, still},
                                                                                      {still, straight(25)},
                                                                                      {straight(25), still},
                                                                                      {far, straight(25)},
                                                                                      {straight(25), far},
                                                                                      {far, still}}) {
    const Evaluation e = evaluate(estimate, truth);
    EXPECT_FALSE(e.scaled);
    for (const Alignment a : {Alignment::none, Alignment::scale, Alignment::se3, Alignment::sim3}) {
      EXPECT_FALSE(e.aligned(a).similarity.scale_known);
      EXPECT_EQ(e.aligned(a).similarity.scale, 1);
      EXPECT_TRUE(std::isfinite(e.aligned(a).ate_m.rmse));
      EXPECT_TRUE(e.aligned(a).similarity.R.allFinite() && e.aligned(a).similarity.t.allFinite());
    }
    EXPECT_TRUE(e.raw.poses.allFinite() && e.raw.motions.allFinite());
  }
  EXPECT_NEAR(evaluate(still, straight(25)).none.ate_m.max, 24, 1e-12);
  EXPECT_EQ(evaluate(straight(25), still).raw.segments.all.has_value(), false);
}

TEST(KnownCases, ScaleAloneDoesNotMirror) {
  Trajectory backwards = straight(50, -1);
  const Evaluation e = evaluate(backwards, straight(50));
  EXPECT_FALSE(e.scale.similarity.scale_known) << "no positive scale makes a drive backwards better";
  EXPECT_NEAR(e.scale.ate_m.max, 98, 1e-12);
}

TEST(KnownCases, BadArgumentsAreRefused) {
  const PosePairs pairs = pairs_of(straight(5), straight(5));
  const double lengths[] = {1.0}, none[] = {0.0}, nan[] = {std::nan("")};
  EXPECT_THROW(segment_errors(pairs, 1, lengths, 0), std::invalid_argument);
  EXPECT_THROW(segment_errors(pairs, 1, none, 1), std::invalid_argument);
  EXPECT_THROW(segment_errors(pairs, 1, nan, 1), std::invalid_argument);
  EXPECT_THROW(statistics({}), std::invalid_argument);
  EXPECT_THROW(align({}, Alignment::sim3), std::invalid_argument);
}

}  // namespace
}  // namespace pavo
