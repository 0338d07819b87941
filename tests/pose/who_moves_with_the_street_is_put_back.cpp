#include <gtest/gtest.h>

#include "stages/pose/put_back.h"
#include "tests/pose/worlds.h"

namespace pavo::test {
namespace {

// A box 200 px wide and 240 high, left of the way and across the horizon.
const PersonBox kBox{250, 90, 200, 240, 0.5f};

SE3 unit(SE3 T) {
  T.t.normalize();
  return T;
}

PointPair pair_of(const Eigen::Vector2d& previous, const Eigen::Vector2d& current) {
  return {static_cast<float>(previous.x()), static_cast<float>(previous.y()), static_cast<float>(current.x()),
          static_cast<float>(current.y())};
}

/// Points of the street 6 to 12 m away that are seen in the box.
PointPairs street_in(const PersonBox& box, const SE3& T_c_p, int n) {
  Random random(3);
  PointPairs pairs;
  while (static_cast<int>(pairs.size()) < n) {
    const Eigen::Vector3d p = unproject(1226 * random.uniform(), 370 * random.uniform(), 6 + 6 * random.uniform());
    const Eigen::Vector2d current = project(T_c_p * p);
    if (in_outline(box, static_cast<float>(current.x()), static_cast<float>(current.y()), {}))
      pairs.push_back(pair_of(project(p), current));
  }
  return pairs;
}

/// Points on somebody who moves so many pixels in the picture, whatever the camera does.
PointPairs person_in(const PersonBox& box, const Eigen::Vector2d& moved, int n) {
  Random random(4);
  PointPairs pairs;
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector2d x(static_cast<double>(box.x) + static_cast<double>(box.width) * random.uniform(),
                            static_cast<double>(box.y) + static_cast<double>(box.height) * random.uniform());
    pairs.push_back(pair_of(x - moved, x));
  }
  return pairs;
}

std::size_t count(const PointPairs& pairs, const People& people, const SE3& T_c_p) {
  PointPairs street(2);  // what is there stays
  put_back(pairs, people, {}, kCamera, unit(T_c_p), {}, street);
  return street.size() - 2;
}

const SE3 kStraight = motion({0, 0, 0}, {0, 0, -0.8});
const SE3 kTurn = motion({0, 0.03, 0}, {0.05, 0, -0.8});

TEST(PutBack, AFalseAlarmIsPutBackWhole) {
  for (const SE3& T : {kStraight, kTurn}) EXPECT_EQ(count(street_in(kBox, T, 40), {kBox}, T), 40u);
}

TEST(PutBack, WhoWalksAlongWithTheCameraIsNot) {
  for (const SE3& T : {kStraight, kTurn}) EXPECT_EQ(count(person_in(kBox, {0, 0}, 40), {kBox}, T), 0u);
}

TEST(PutBack, WhoCrossesTheStreetIsNot) {
  for (const SE3& T : {kStraight, kTurn}) EXPECT_EQ(count(person_in(kBox, {3, 5}, 40), {kBox}, T), 0u);
}

TEST(PutBack, NorIsTheStreetAroundAPerson) {
  PointPairs pairs = person_in(kBox, {3, 5}, 30);
  for (const PointPair& pair : street_in(kBox, kStraight, 30)) pairs.push_back(pair);
  EXPECT_EQ(count(pairs, {kBox}, kStraight), 0u);
}

TEST(PutBack, APersonInFrontOfAFalseAlarmStaysOut) {
  const PersonBox person{400, 90, 100, 240, 0.5f};  // its right half
  const PointPairs alarm = street_in(kBox, kStraight, 200);
  PointPairs pairs = alarm;
  for (const PointPair& pair : person_in(person, {3, 5}, 30)) pairs.push_back(pair);
  const std::size_t beside =
      static_cast<std::size_t>(std::count_if(alarm.begin(), alarm.end(), [&](const PointPair& p) {
        return !in_outline(person, p.x_current, p.y_current, {});
      }));
  EXPECT_EQ(count(pairs, {kBox, person}, kStraight), beside);
  EXPECT_GT(beside, 50u);
}

TEST(PutBack, TooFewMatchesDecideNothing) {
  EXPECT_EQ(count(street_in(kBox, kStraight, 3), {kBox}, kStraight), 0u);
  EXPECT_EQ(count({}, {kBox}, kStraight), 0u);
}

/// The whole chain: half the picture is taken for a person, and does not move like one.
TEST(PutBack, OdometryCountsOnWhatIsPutBack) {
  const World world(1);
  const std::vector<SE3> truth = drive(6);
  const People crowd{{-100, -100, 700, 600, 0.3f}};
  std::size_t matches[2] = {};
  for (const bool put : {false, true}) {
    OdometryOptions options;
    options.put_back = put;
    Odometry odometry(kCamera, options, true_steps(truth));
    Features before;
    PoseResult result;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      Features now = world.seen_from(truth[i], static_cast<std::int64_t>(i));
      odometry(at(static_cast<std::int64_t>(i)), {&now, nullptr}, i > 0 ? FrameView{&before, nullptr} : FrameView{},
               crowd, result);
      EXPECT_EQ(result.matches, static_cast<int>(result.pairs.size()));
      EXPECT_EQ(result.is_inlier.size(), result.pairs.size());
      before = std::move(now);
    }
    matches[put ? 1 : 0] = result.pairs.size();
    EXPECT_LT((result.T_w_c.t - truth.back().t).norm(), 0.05);
  }
  EXPECT_GT(matches[1], matches[0] + 30);
}

}  // namespace
}  // namespace pavo::test
