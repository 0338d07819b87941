// Which poses belong together, by time or by number.
#include "stages/evaluation/association.h"

#include <gmock/gmock.h>

#include <limits>

#include "tests/evaluation/paths.h"

namespace pavo {
namespace {

using test::straight;
using ::testing::HasSubstr;

constexpr std::int64_t kMs = 1'000'000;

Trajectory timed(std::size_t count, std::int64_t first_ns, std::int64_t period_ns) {
  Trajectory path = straight(count);
  for (std::size_t i = 0; i < count; ++i) path.t_ns.push_back(first_ns + static_cast<std::int64_t>(i) * period_ns);
  return path;
}

std::string complaint(const Trajectory& estimate, const Trajectory& truth) {
  try {
    associate(estimate, truth);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(Association, ByNumberWhereNotBothHaveTimes) {
  const PosePairs pairs = associate(timed(10, 0, 100 * kMs), straight(10));
  EXPECT_EQ(pairs.truth.size(), 10u);
  EXPECT_FALSE(pairs.by_time);
  EXPECT_THAT(complaint(timed(9, 0, kMs), straight(10)), HasSubstr("the estimate has 9 poses, the ground truth 10"));
  EXPECT_THAT(complaint(straight(1), straight(1)), HasSubstr("expected two or more"));
}

TEST(Association, ByTimeFindsAPartOfTheTruth) {
  // Every fifth frame, a little late, from the middle on.
  const PosePairs pairs = associate(timed(10, 5'000 * kMs + 3, 500 * kMs), timed(100, 0, 100 * kMs));
  ASSERT_EQ(pairs.truth.size(), 10u);
  EXPECT_TRUE(pairs.by_time);
  EXPECT_EQ(pairs.largest_gap_ns, 3);
  for (std::size_t i = 0; i < 10; ++i) EXPECT_EQ(pairs.truth[i].t.z(), 50.0 + 5 * static_cast<double>(i));
}

TEST(Association, ByTimeIsOneToOneAndTakesTheNearest) {
  // Ten poses of the estimate for each of the truth: only the nearest of them counts.
  const Trajectory truth = timed(5, 0, 100 * kMs), estimate = timed(50, 4 * kMs, 10 * kMs);
  const PosePairs pairs = associate(estimate, truth);
  ASSERT_EQ(pairs.truth.size(), 5u);
  for (std::size_t k = 0; k < 5; ++k) {
    std::size_t nearest = 0;  // by brute force
    for (std::size_t i = 0; i < 50; ++i) {
      if (std::abs(estimate.t_ns[i] - truth.t_ns[k]) < std::abs(estimate.t_ns[nearest] - truth.t_ns[k])) nearest = i;
    }
    EXPECT_EQ(pairs.estimate[k].t, estimate.T_w_c[nearest].t);
  }
  EXPECT_EQ(pairs.largest_gap_ns, 4 * kMs);
}

TEST(Association, RefusesClocksThatDoNotMeet) {
  EXPECT_THAT(complaint(timed(10, 0, 100 * kMs), timed(10, 1'403'715'273'000 * kMs, 100 * kMs)),
              HasSubstr("of which 0 agree in time (at most 20 ms apart)"));
  EXPECT_THAT(complaint(timed(10, 50 * kMs, 100 * kMs), timed(10, 0, 100 * kMs)), HasSubstr("of which 0 agree"));
  EXPECT_EQ(associate(timed(10, 50 * kMs, 100 * kMs), timed(10, 0, 100 * kMs), 50 * kMs).truth.size(), 10u);
}

TEST(Association, RefusesWhatIsNoPath) {
  Trajectory bad = straight(5);
  bad.T_w_c[3].t.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(complaint(bad, straight(5)), HasSubstr("pose 3 of the estimate is not finite"));
  EXPECT_THAT(complaint(straight(5), bad), HasSubstr("pose 3 of the ground truth is not finite"));
  bad = timed(5, 0, -kMs);
  EXPECT_THAT(complaint(bad, straight(5)), HasSubstr("do not increase"));
  bad = timed(5, 0, kMs);
  bad.t_ns.pop_back();
  EXPECT_THAT(complaint(bad, straight(5)), HasSubstr("5 poses but 4 times"));
  bad = timed(2, 0, std::numeric_limits<std::int64_t>::max());
  EXPECT_THAT(complaint(bad, straight(2)), HasSubstr("out of range"));
  EXPECT_THAT(complaint({}, {}), HasSubstr("expected two or more"));
}

}  // namespace
}  // namespace pavo
