#include <gtest/gtest.h>

#include <limits>

#include "tests/pose/worlds.h"

namespace pavo::test {
namespace {

struct Driven {
  std::vector<SE3> truth;
  std::vector<Features> features;
  std::vector<PoseResult> results;
};

enum class Fate { seen, missed, black };

// Drives through the world; `fate` tells what becomes of each frame.
template <class Fates>
Driven run(std::vector<SE3> truth, const Fates& fate, const OdometryOptions& options = {},
           std::shared_ptr<const StepLength> scale = nullptr, const People& people = {}) {
  Driven driven;
  const World world(1);
  driven.truth = std::move(truth);
  Odometry odometry(kCamera, options, scale ? scale : true_steps(driven.truth));
  driven.features.resize(driven.truth.size());
  driven.results.resize(driven.truth.size());
  bool previous_there = false;
  for (std::size_t i = 0; i < driven.truth.size(); ++i) {
    const auto frame = static_cast<std::int64_t>(i);
    const FrameView previous = previous_there ? FrameView{&driven.features[i - 1], nullptr} : FrameView{};
    if (fate(i) == Fate::missed) {
      odometry.missed(at(frame), previous, driven.results[i]);
    } else {
      if (fate(i) == Fate::seen) driven.features[i] = world.seen_from(driven.truth[i], frame);
      odometry(at(frame), {&driven.features[i], nullptr}, previous, people, driven.results[i]);
    }
    if (i > 0) driven.features[i - 1] = {};  // its slot is gone
    previous_there = fate(i) != Fate::missed;
    EXPECT_TRUE(orthonormal(driven.results[i].T_w_c.R)) << i;
    EXPECT_TRUE(driven.results[i].T_w_c.t.allFinite()) << i;
    EXPECT_EQ(driven.results[i].is_inlier.size(), driven.results[i].pairs.size());
    EXPECT_EQ(driven.results[i].matches, static_cast<int>(driven.results[i].pairs.size()));
  }
  return driven;
}

Fate always(std::size_t) {
  return Fate::seen;
}

double end_error(const Driven& run) {
  return (run.results.back().T_w_c.t - run.truth.back().t).norm();
}

TEST(Odometry, FollowsTheTruth) {
  const Driven drive_run = run(drive(30), always);
  EXPECT_LT(end_error(drive_run), 0.02 * 15);
  EXPECT_TRUE(drive_run.results[0].T_w_c.R.isIdentity(0) && drive_run.results[0].T_w_c.t.isZero(0));
  EXPECT_EQ(drive_run.results[0].reason, PoseReason::first_frame);
  for (std::size_t i = 1; i < 30; ++i) {
    EXPECT_EQ(drive_run.results[i].quality, Quality::tracked);
    EXPECT_EQ(drive_run.results[i].reference_frame, static_cast<std::int64_t>(i) - 1);
    EXPECT_NEAR(drive_run.results[i].step_m, (drive_run.truth[i].t - drive_run.truth[i - 1].t).norm(), 1e-9);
  }
}

TEST(Odometry, IsTheSameToTheBit) {
  const Driven a = run(drive(10), always), b = run(drive(10), always);
  for (std::size_t i = 0; i < 10; ++i) EXPECT_TRUE(a.results[i].T_w_c.t == b.results[i].T_w_c.t);
}

TEST(Odometry, UnitStepsHaveLengthOne) {
  const Driven unit = run(drive(10), always, {}, std::make_shared<UnitStep>());
  for (std::size_t i = 1; i < 10; ++i)
    EXPECT_NEAR((unit.results[i].T_w_c.t - unit.results[i - 1].T_w_c.t).norm(), 1, 1e-9);
}

TEST(Odometry, AGapIsBridgedFromTheLastGoodFrame) {
  for (const Fate gap : {Fate::missed, Fate::black}) {
    const Driven bridged = run(drive(30), [&](std::size_t i) { return i >= 10 && i < 13 ? gap : Fate::seen; });
    EXPECT_LT(end_error(bridged), 0.02 * 15);
    for (std::size_t i = 10; i < 13; ++i) {
      EXPECT_EQ(bridged.results[i].quality, Quality::coasting);
      EXPECT_LT((bridged.results[i].T_w_c.t - bridged.truth[i].t).norm(), 0.4);  // constant velocity
    }
    EXPECT_EQ(bridged.results[13].reference_frame, 9);
    EXPECT_EQ(bridged.results[13].quality, Quality::tracked);
    EXPECT_EQ(bridged.results[14].reference_frame, 13);
    EXPECT_EQ(bridged.results[10].reason, gap == Fate::missed ? PoseReason::missed : PoseReason::too_few_keypoints);
  }
}

TEST(Odometry, GoesOnBehindALongGap) {
  const Driven broken = run(drive(40), [](std::size_t i) { return i >= 10 && i < 30 ? Fate::missed : Fate::seen; });
  EXPECT_EQ(broken.results[30].quality, Quality::coasting);
  EXPECT_EQ(broken.results[30].reason, PoseReason::no_reference);
  EXPECT_EQ(broken.results[31].quality, Quality::tracked);
  EXPECT_EQ(broken.results[39].quality, Quality::tracked);
}

TEST(Odometry, FailedFramesBeforeTheFirstGoodOneStayAtTheOrigin) {
  const Driven late = run(drive(8), [](std::size_t i) {
    return i < 2 ? Fate::missed : i == 2 ? Fate::black : Fate::seen;
  });
  for (std::size_t i = 0; i <= 3; ++i) EXPECT_TRUE(late.results[i].T_w_c.t.isZero(0));
  EXPECT_EQ(late.results[3].reason, PoseReason::first_frame);
  EXPECT_EQ(late.results[4].quality, Quality::tracked);
}

TEST(Odometry, NothingButBlackFramesIsNothingButTheOrigin) {
  const Driven black = run(drive(5), [](std::size_t) { return Fate::black; });
  for (const PoseResult& result : black.results) {
    EXPECT_EQ(result.quality, Quality::coasting);
    EXPECT_TRUE(result.T_w_c.t.isZero(0));
  }
}

TEST(Odometry, StandingKeepsThePoseToTheBit) {
  std::vector<SE3> stop = drive(6);
  for (int i = 0; i < 10; ++i) stop.push_back(stop.back());
  for (int i = 0; i < 6; ++i) stop.push_back(stop.back() * motion({0, 0.01, 0}, {0.02, 0, 0.5}));
  const Driven run_stop = run(stop, always);
  for (std::size_t i = 6; i < 16; ++i) {
    EXPECT_EQ(run_stop.results[i].quality, Quality::standing) << i;
    EXPECT_TRUE(run_stop.results[i].T_w_c.t == run_stop.results[5].T_w_c.t);
    EXPECT_TRUE(run_stop.results[i].T_w_c.R == run_stop.results[5].T_w_c.R);
  }
  for (std::size_t i = 16; i < 22; ++i) EXPECT_EQ(run_stop.results[i].quality, Quality::tracked) << i;
  EXPECT_LT(end_error(run_stop), 0.02 * 6);
}

TEST(Odometry, CreepingIsNotLostInStandstills) {
  std::vector<SE3> creep(1);
  while (creep.size() < 200) creep.push_back(creep.back() * motion({0, 0, 0}, {0, 0, 0.005}));
  const Driven slow = run(creep, always);
  EXPECT_NEAR(slow.results.back().T_w_c.t.z(), creep.back().t.z(), 0.1 * creep.back().t.z());
}

TEST(Odometry, UnitStepsAfterAStandstillHaveLengthOne) {
  std::vector<SE3> stop = drive(4);
  for (int i = 0; i < 15; ++i) stop.push_back(stop.back());
  stop.push_back(stop.back() * motion({0, 0, 0}, {0, 0, 0.5}));
  const Driven run_stop = run(stop, always, {}, std::make_shared<UnitStep>());
  EXPECT_NEAR((run_stop.results[19].T_w_c.t - run_stop.results[18].T_w_c.t).norm(), 1, 1e-9);
}

TEST(Odometry, TurningOnTheSpotMovesNothingWithoutAScale) {
  std::vector<SE3> turn(1);
  while (turn.size() < 20) turn.push_back(turn.back() * motion({0, 0.02, 0}, {0, 0, 0}));
  const Driven run_turn = run(turn, always, {}, std::make_shared<UnitStep>());
  EXPECT_LT(run_turn.results.back().T_w_c.t.norm(), 1e-9);
  EXPECT_LT(degrees_between(run_turn.results.back().T_w_c.R, turn.back().R), 0.5);
}

TEST(Odometry, UnknownLengthsAreTheMotionModels) {
  std::vector<Eigen::Vector3d> positions;
  for (const SE3& pose : drive(5)) positions.push_back(pose.t);  // and then no more
  const Driven unknown = run(drive(15), always, {}, std::make_shared<GroundtruthStep>(positions));
  EXPECT_LT(end_error(unknown), 0.02 * 7);
}

TEST(Odometry, FeaturesOnPeopleAreDroppedAndCounted) {
  const People crowd{{-600, -200, 1200, 800, 1}};
  const Driven half = run(drive(10), always, {}, nullptr, crowd);
  for (const PoseResult& result : half.results) {
    EXPECT_GT(result.dropped_on_people, 50);
    EXPECT_EQ(result.dropped_on_people, std::count(result.kept.begin(), result.kept.end(), 0));
    EXPECT_EQ(static_cast<int>(result.kept.size()), result.keypoints);
    for (const PointPair& pair : result.pairs) EXPECT_TRUE(pair.x_previous > 530 && pair.x_current > 530);
  }
  EXPECT_LT(end_error(half), 0.05 * 5);

  const Driven all = run(drive(4), always, {}, nullptr, {{-500, -500, 3000, 3000, 1}});
  for (const PoseResult& result : all.results) EXPECT_EQ(result.reason, PoseReason::too_few_after_people);
}

TEST(Odometry, WrongCallsAreRefused) {
  const auto unit = std::make_shared<UnitStep>();
  Camera broken = kCamera;
  broken.fx = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Odometry(broken, {}, unit), std::runtime_error);
  EXPECT_THROW(Odometry(Camera{}, {}, unit), std::runtime_error);
  EXPECT_THROW(Odometry(kCamera, {}, nullptr), std::invalid_argument);
  Odometry odometry(kCamera, {.tracker = Tracker::klt}, unit);
  PoseResult result;
  EXPECT_THROW(odometry(at(0), {}, {}, {}, result), std::invalid_argument);
  const Features features = World(1).seen_from({}, 0);
  odometry(at(0), {&features, nullptr}, {}, {}, result);
  EXPECT_THROW(odometry(at(1), {&features, nullptr}, {&features, nullptr}, {}, result), std::invalid_argument);
}

}  // namespace
}  // namespace pavo::test
