#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <tuple>

#include "stages/people/scan_hog.h"
#include "stages/people/standing_prior.h"
#include "tests/people/pictures.h"

namespace pavo {
namespace {

constexpr StandingPrior kPrior{.horizon_px = 170, .camera_height_m = 1.65, .slack_px = 10};

/// A person of so many metres, so many metres away, seen by a level camera of 700 px focal length.
PersonBox person(double tall_m, double away_m, double floats_m = 0) {
  const double feet = kPrior.horizon_px + 700 * (kPrior.camera_height_m - floats_m) / away_m;
  const double height = 700 * tall_m / away_m;
  return {100, static_cast<float>(feet - height), static_cast<float>(0.41 * height), static_cast<float>(height), 1};
}

TEST(StandingPrior, PeopleOfAnyDistanceStand) {
  for (const double tall : {1.25, 1.5, 1.75, 2.05})
    for (const double away : {3.0, 5.0, 9.0, 14.0}) EXPECT_TRUE(stands_on_ground(kPrior, person(tall, away)));
}

TEST(StandingPrior, WhatFloatsOrIsSunkOrATowerDoesNot) {
  EXPECT_FALSE(stands_on_ground(kPrior, person(1.7, 5, 0.8)));
  EXPECT_FALSE(stands_on_ground(kPrior, person(1.7, 5, -1)));
  EXPECT_FALSE(stands_on_ground(kPrior, person(4, 9)));
  EXPECT_FALSE(stands_on_ground(kPrior, person(0.6, 4)));
}

TEST(StandingPrior, SlackIsGivenBothWays) {
  StandingPrior wide = kPrior;
  wide.slack_px = 200;
  EXPECT_TRUE(stands_on_ground(wide, person(1.7, 5, 0.8)));
  EXPECT_TRUE(stands_on_ground(wide, person(1.7, 5, -1)));
}

TEST(StandingPrior, WhoDoesNotStandIsDroppedInOrder) {
  Detections people{person(1.7, 5), person(1.7, 5, 1), person(1.6, 8)};
  const PersonBox first = people[0], third = people[2];
  keep_who_stands(kPrior, people);
  ASSERT_EQ(people.size(), 2u);
  EXPECT_EQ(people[0].y, first.y);
  EXPECT_EQ(people[1].y, third.y);
}

/// The rows that are scanned are just those whose windows hold a person that stands: scores and places to the bit.
TEST(StandingPrior, TheScanIsThePlainOneWithoutWhatDoesNotStand) {
  const Image image = test::textured(300, 370, 11);
  const PedestrianModel model = test::random_model(11);
  ScanHogOptions options{.scale_step = 1.15, .threshold = 0, .largest_share = 2};
  Detections plain, with;
  ScanPeopleHog::Scratch a, b;
  ScanPeopleHog(model, options)(image, plain, a);
  const std::size_t all = plain.size();
  keep_who_stands(kPrior, plain);
  options.standing = kPrior;
  const ScanPeopleHog scan(model, options);
  scan(image, with, b);
  ASSERT_EQ(with.size(), plain.size());
  EXPECT_LT(with.size(), all * 2 / 3);
  EXPECT_GT(with.size(), 100u);
  for (std::size_t i = 0; i < with.size(); ++i) {
    EXPECT_EQ(std::tuple(with[i].x, with[i].y, with[i].height, with[i].score),
              std::tuple(plain[i].x, plain[i].y, plain[i].height, plain[i].score));
  }
  scan(image, plain, b);  // scratch that is used again
  EXPECT_EQ(plain.size(), with.size());

  // Another ground for one frame, as odometry sees it.
  const std::optional<StandingPrior> other = StandingPrior{.horizon_px = 120, .camera_height_m = 1.65, .slack_px = 10};
  scan(image, other, ScanLevels::all, with, b);
  options.standing = other;
  ScanPeopleHog(model, options)(image, plain, a);
  ASSERT_EQ(with.size(), plain.size());
  for (std::size_t i = 0; i < with.size(); ++i) EXPECT_EQ(with[i].score, plain[i].score);
  scan(image, std::nullopt, ScanLevels::all, with, b);
  EXPECT_EQ(with.size(), all);
  EXPECT_THROW(scan(image, StandingPrior{}, ScanLevels::all, with, b), std::invalid_argument);
}

TEST(StandingPrior, AHorizonFarOffLeavesNothingToScan) {
  const Image image = test::textured(200, 200, 12);
  const PedestrianModel model = test::random_model(12);
  for (const double horizon : {-2000.0, 2000.0}) {
    Detections found;
    ScanPeopleHog::Scratch scratch;
    ScanHogOptions options{.threshold = 0};
    options.standing = StandingPrior{.horizon_px = horizon, .camera_height_m = 1.65};
    ScanPeopleHog(model, options)(image, found, scratch);
    EXPECT_TRUE(found.empty());
  }
}

TEST(StandingPrior, RefusesWhatIsNoGround) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NO_THROW(check(kPrior));
  for (double StandingPrior::*part : {&StandingPrior::horizon_px, &StandingPrior::camera_height_m,
                                      &StandingPrior::slack_px, &StandingPrior::least_m, &StandingPrior::most_m}) {
    StandingPrior wrong = kPrior;
    wrong.*part = kNaN;
    EXPECT_THROW(check(wrong), std::invalid_argument);
  }
  for (const auto& [height, slack, least] : {std::tuple(0.0, 1.0, 1.2), {1.6, -1.0, 1.2}, {1.6, 1.0, 3.0}}) {
    StandingPrior wrong = kPrior;
    wrong.camera_height_m = height;
    wrong.slack_px = slack;
    wrong.least_m = least;
    EXPECT_THROW(check(wrong), std::invalid_argument);
  }
}

}  // namespace
}  // namespace pavo
