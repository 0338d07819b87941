#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "stages/people/overlap.h"
#include "stages/people/track_people.h"

namespace pavo {
namespace {

PersonBox walker(int frame, float score = 1) {
  const float t = static_cast<float>(frame);
  return {100 + 4 * t, 50 + 0.5f * t, 40 + 0.4f * t, 100 + t, score};
}

struct Tracker {
  TrackPeople track;
  People people;
  const People& see(const Detections& d) {
    track(d, people);
    return people;
  }
  const People& miss() {
    track.missed(people);
    return people;
  }
};

TEST(TrackPeople, ADetectionIsAPersonAtOnce) {
  Tracker t;
  const People& people = t.see({walker(0, 0.7f)});
  ASSERT_EQ(people.size(), 1u);
  EXPECT_FLOAT_EQ(people[0].x, walker(0).x);
  EXPECT_FLOAT_EQ(people[0].height, walker(0).height);
  EXPECT_FLOAT_EQ(people[0].score, 0.7f);
}

TEST(TrackPeople, AMissedDetectionIsBridgedAlongTheWay) {
  Tracker t;
  for (int k = 0; k < 15; ++k) t.see({walker(k)});
  for (int k = 15; k < 30; ++k) {
    const People& people = t.see({});
    ASSERT_EQ(people.size(), 1u) << "frame " << k;
    EXPECT_GT(intersection_over_union(people[0], walker(k)), 0.9f) << "frame " << k;
  }
  EXPECT_TRUE(t.see({}).empty());
}

TEST(TrackPeople, FramesThatWereNotScannedCarryTheBoxesOn) {
  Tracker t;
  for (int k = 0; k < 15; ++k) t.see({walker(k)});
  for (int k = 15; k < 18; ++k) ASSERT_EQ(t.miss().size(), 1u);
  EXPECT_GT(intersection_over_union(t.people[0], walker(17)), 0.9f);
  EXPECT_EQ(t.see({walker(18)}).size(), 1u) << "the same person, not a second one";
  for (int k = 0; k <= TrackPeopleOptions{}.longest_misses; ++k) t.miss();
  EXPECT_TRUE(t.people.empty()) << "a guess does not live for ever";
}

TEST(TrackPeople, APersonIsBelievedForAsLongAsTheyWereSeen) {
  const TrackPeopleOptions options;
  for (const int seen : {3, 5, 6, 9, 20, 50}) {
    Tracker t;
    for (int k = 0; k < seen; ++k) t.see({walker(0)});
    int survived = 0;
    while (!t.see({}).empty()) ++survived;
    EXPECT_EQ(survived, std::clamp(seen, options.confirmed_misses, options.longest_misses)) << seen;
  }
}

TEST(TrackPeople, AFlashIsForgottenSoonerThanAConfirmedPerson) {
  Tracker t;
  t.see({walker(0)});
  for (int k = 0; k < TrackPeopleOptions{}.tentative_misses; ++k) EXPECT_EQ(t.see({}).size(), 1u);
  EXPECT_TRUE(t.see({}).empty());
}

TEST(TrackPeople, AWeakDetectionContinuesAPersonButBeginsNone) {
  TrackPeopleOptions options;
  options.birth_score = 0.5f;
  Tracker t{TrackPeople(options), {}};
  EXPECT_TRUE(t.see({walker(0, 0.4f)}).empty());
  EXPECT_EQ(t.see({walker(1, 0.6f)}).size(), 1u);
  for (int k = 2; k < 40; ++k) ASSERT_EQ(t.see({walker(k, 0.1f)}).size(), 1u);
  EXPECT_FLOAT_EQ(t.people[0].score, 0.1f);
}

TEST(TrackPeople, TwoWhoPassEachOtherStayTwo) {
  Tracker t;
  for (int k = 0; k < 30; ++k) {
    const float s = 6 * static_cast<float>(k);
    Detections seen{{100 + s, 50, 40, 100, 1}, {270 - s, 55, 44, 110, 1}};
    if (k == 14 || k == 15) seen.pop_back();  // hidden behind the first
    ASSERT_EQ(t.see(seen).size(), 2u) << "frame " << k;
  }
  EXPECT_NEAR(t.people[0].x, 100 + 6 * 29, 4);
  EXPECT_NEAR(t.people[1].x, 270 - 6 * 29, 4);
}

TEST(TrackPeople, EachDetectionServesOnePersonOnly) {
  Tracker t;
  t.see({{100, 50, 40, 100, 1}, {110, 50, 40, 100, 1}});
  for (int k = 0; k < 3; ++k) t.see({{105, 50, 40, 100, 1}});
  EXPECT_EQ(t.people.size(), 1u);
}

TEST(TrackPeople, BoxesThatAreNoneAreIgnored) {
  Tracker t;
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(t.see({{nan, 0, 10, 10, 1}, {0, 0, inf, 10, 1}, {0, 0, 0, 10, 1}, {0, 0, 10, -1, 1}}).empty());
  t.see({walker(0)});
  EXPECT_EQ(t.see({{nan, 0, 10, 10, 1}, walker(1)}).size(), 1u);
}

TEST(TrackPeople, ABoxThatShrinksToNothingEnds) {
  TrackPeopleOptions options;
  options.confirmed_misses = options.longest_misses = 1000;
  Tracker t{TrackPeople(options), {}};
  for (int k = 0; k < 10; ++k) {
    const float h = 100 - 6 * static_cast<float>(k);
    t.see({{100, 50, 0.4f * h, h, 1}});
  }
  for (int k = 0; k < 20; ++k) t.see({});
  EXPECT_TRUE(t.people.empty());
}

TEST(TrackPeople, ResetForgets) {
  Tracker t;
  t.see({walker(0)});
  t.track.reset();
  EXPECT_TRUE(t.miss().empty());
}

TEST(TrackPeople, RefusesOptionsOutOfRange) {
  const auto refused = [](auto change) {
    TrackPeopleOptions options;
    change(options);
    EXPECT_THROW(TrackPeople{options}, std::invalid_argument);
  };
  refused([](auto& o) { o.match_overlap = 0; });
  refused([](auto& o) { o.match_overlap = 1.1f; });
  refused([](auto& o) { o.confirm_hits = 0; });
  refused([](auto& o) { o.tentative_misses = -1; });
  refused([](auto& o) { o.confirmed_misses = -1; });
  refused([](auto& o) { o.longest_misses = o.confirmed_misses - 1; });
  refused([](auto& o) { o.position_gain = std::numeric_limits<float>::quiet_NaN(); });
  refused([](auto& o) { o.velocity_gain = 2; });
}

}  // namespace
}  // namespace pavo
