#include <gtest/gtest.h>

#include "tests/engine/numbers.h"

namespace pavo::test {
namespace {

// Spends a different, pseudo-random time on every number, so that frames overtake each other.
struct UnevenSquare {
  void operator()(const FrameInfo& info, const std::int64_t& in, std::int64_t& out) const {
    std::uint64_t x = info.sequence * 0x9E3779B97F4A7C15u;
    for (std::uint64_t i = 0; i < (x >> 54); ++i) x ^= x << 7, x ^= x >> 9;
    out = x == 1 ? 0 : in * in;
  }
};

std::vector<Delivered> run(const PipelineOptions& options, std::int64_t count, Sum& sum) {
  SteadyClock clock;
  Pipeline<Numbers> pipeline(options, clock);
  std::vector<Delivered> delivered;
  pipeline.source(writes(&Numbers::input));
  pipeline.add("square", reads(&Numbers::input), writes(&Numbers::squared), UnevenSquare{}, parallel);
  pipeline.add("double", reads(&Numbers::input), writes(&Numbers::doubled), Double{}, parallel);
  pipeline.add("sum", reads(&Numbers::squared, &Numbers::doubled), writes(&Numbers::sum), std::ref(sum), in_order);
  pipeline.deliver(collect(delivered));
  Counting source(count);
  pipeline.run(source);
  const Counts counts = pipeline.counts();
  EXPECT_EQ(counts.in, count);
  EXPECT_EQ(counts.done, count);
  EXPECT_EQ(counts.in_flight, 0u);
  return delivered;
}

class Replay : public testing::TestWithParam<std::pair<int, int>> {};

TEST_P(Replay, DeliversEveryFrameOnceInOrderWithTheRightResult) {
  PipelineOptions options = workers(GetParam().first);
  options.slots = GetParam().second;
  Sum sum;
  const std::vector<Delivered> delivered = run(options, 2000, sum);
  ASSERT_EQ(delivered.size(), 2000u);
  std::int64_t expected = 0;
  for (std::int64_t i = 0; i < 2000; ++i) {
    expected += i * i + 2 * i;
    EXPECT_EQ(delivered[i].source_index, i);
    EXPECT_EQ(delivered[i].sum, expected);
    EXPECT_EQ(sum.seen[i], static_cast<std::uint64_t>(i));
  }
}

INSTANTIATE_TEST_SUITE_P(WorkersAndSlots, Replay,
                         testing::Values(std::pair(1, 1), std::pair(1, 2), std::pair(2, 1), std::pair(2, 3),
                                         std::pair(2, 0), std::pair(4, 5), std::pair(8, 32)));

TEST(Replay, OfNothingEndsAtOnce) {
  Sum sum;
  EXPECT_TRUE(run(workers(3), 0, sum).empty());
}

// The difference to the frame before: what `previous` is for.
struct Difference {
  int nulls = 0;
  void operator()(const std::int64_t& now, const std::int64_t* before, std::int64_t& out) {
    nulls += before == nullptr;
    out = before ? now - *before : 0;
  }
  void missed(const std::int64_t* before, std::int64_t& out) { out = before ? -1 : -2; }
};

TEST(Previous, IsTheFrameBefore) {
  SteadyClock clock;
  for (const int slots : {2, 3, 7}) {
    PipelineOptions options = workers(3);
    options.slots = slots;
    Pipeline<Numbers> pipeline(options, clock);
    Difference difference;
    std::vector<Delivered> delivered;
    pipeline.source(writes(&Numbers::input));
    pipeline.add("square", reads(&Numbers::input), writes(&Numbers::squared), Square{}, parallel);
    pipeline.add("difference", reads(&Numbers::squared, previous(&Numbers::squared)), writes(&Numbers::sum),
                 std::ref(difference), in_order);
    pipeline.deliver(collect(delivered));
    Counting source(500);
    pipeline.run(source);
    EXPECT_EQ(difference.nulls, 1);
    for (std::int64_t i = 1; i < 500; ++i) ASSERT_EQ(delivered[i].sum, 2 * i - 1);
  }
}

TEST(Previous, IsNullBehindAFailedFrameAndGivenToTheMissedOne) {
  SteadyClock clock;
  Pipeline<Numbers> pipeline(workers(2), clock);
  Difference difference;
  std::vector<Delivered> delivered;
  pipeline.source(writes(&Numbers::input));
  pipeline.add("square", reads(&Numbers::input), writes(&Numbers::squared), Square{}, parallel);
  pipeline.add("difference", reads(&Numbers::squared, previous(&Numbers::squared)), writes(&Numbers::sum),
               std::ref(difference), in_order);
  pipeline.deliver(collect(delivered));
  Counting source(10, {4, 5});
  pipeline.run(source);
  EXPECT_EQ(delivered[4].sum, -1);  // missed, with frame 3 at hand
  EXPECT_EQ(delivered[5].sum, -2);  // missed, and frame 4 has nothing to give
  EXPECT_EQ(delivered[6].sum, 0);   // done, but without a previous one
  EXPECT_EQ(delivered[7].sum, 13);
  EXPECT_EQ(difference.nulls, 2);
}

// A scratch belongs to one worker: two calls at the same time never share it.
struct UsesScratch {
  struct Scratch {
    std::atomic<int> users{0};
    std::vector<std::int64_t> memory;
  };
  void operator()(const std::int64_t& in, std::int64_t& out, Scratch& scratch) const {
    if (scratch.users.fetch_add(1) != 0) throw std::logic_error("two at once");
    scratch.memory.assign(100, in);
    out = scratch.memory[50];
    scratch.users.fetch_sub(1);
  }
};

TEST(Scratch, IsTheWorkersOwn) {
  SteadyClock clock;
  Pipeline<Numbers> pipeline(workers(4), clock);
  pipeline.source(writes(&Numbers::input));
  pipeline.add("copy", reads(&Numbers::input), writes(&Numbers::sum), UsesScratch{}, parallel);
  std::vector<Delivered> delivered;
  pipeline.deliver(collect(delivered));
  Counting source(3000);
  pipeline.run(source);
  for (std::int64_t i = 0; i < 3000; ++i) ASSERT_EQ(delivered[i].sum, i);
  EXPECT_EQ(pipeline.counts().failed, 0u);
}

}  // namespace
}  // namespace pavo::test
