#include <gtest/gtest.h>

#include "stages/matches/nearest.h"
#include "tests/matches/random_features.h"
#include "tests/support/counted_allocations.h"

namespace pavo::test {
namespace {

TEST(NearestMemory, IsAllocatedOnceForTheLargestFrame) {
  const Features a = random_features(220, 1), b = seen_again(a, 0.05f, 2), c = random_features(100, 3);
  const std::vector<std::uint8_t> keep(220, 1);
  MatchNearest::Scratch scratch;
  Matches matches;
  PointPairs pairs;
  const MatchNearest match;
  match(a, b, matches, scratch);
  pairs_of(matches, a, b, pairs);
  const std::int32_t* const panels = scratch.panels.data.get();  // aligned memory does not come from operator new
  const std::int32_t* const lanes = scratch.lane_score.data.get();
  const std::int32_t* const rows = scratch.previous.score.data.get();
  const std::int32_t* const columns = scratch.current.score.data.get();
  const long before = allocations.load();
  for (int n = 0; n < 3; ++n) {
    match(a, c, matches, scratch);
    match(c, b, matches, scratch);
    match(a, b, keep, keep, matches, scratch);
    pairs_of(matches, a, b, pairs);
  }
  EXPECT_EQ(allocations.load() - before, 0);
  EXPECT_EQ(scratch.panels.data.get(), panels);
  EXPECT_EQ(scratch.lane_score.data.get(), lanes);
  EXPECT_EQ(scratch.previous.score.data.get(), rows);
  EXPECT_EQ(scratch.current.score.data.get(), columns);
}

}  // namespace
}  // namespace pavo::test
