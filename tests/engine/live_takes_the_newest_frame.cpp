#include <gtest/gtest.h>

#include <semaphore>

#include "tests/engine/numbers.h"

namespace pavo::test {
namespace {

// Holds each frame until the test lets it go.
struct CountedGate {
  std::counting_semaphore<1000>& entered;
  std::counting_semaphore<1000>& opened;
  void operator()(const std::int64_t& in, std::int64_t& out) const {
    entered.release();
    opened.acquire();
    out = in;
  }
};

// Advances the clock only when the source sleeps for it.
void advance(ManualClock& clock, std::int64_t by_ns) {
  while (clock.sleepers() == 0) std::this_thread::yield();
  clock.advance(by_ns);
}

// Also with credits left, while no worker could begin with it: inside it would only grow old.
class LiveCredits : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Live, LiveCredits, testing::Values(1, 4));

TEST_P(LiveCredits, AFrameThatCannotStartIsReplacedByTheNextAndCounted) {
  ManualClock clock;
  PipelineOptions options = workers(1);
  options.admission = Admission::live;
  options.live_credits = GetParam();
  options.slots = 6;
  Pipeline<Numbers> pipeline(options, clock);
  std::counting_semaphore<1000> entered{0}, opened{0};
  std::vector<Delivered> delivered;
  pipeline.source(writes(&Numbers::input));
  pipeline.add("gate", reads(&Numbers::input), writes(&Numbers::sum), CountedGate{entered, opened}, parallel);
  pipeline.deliver(collect(delivered));
  Counting source(10, {}, 10 * kMs);
  std::jthread runner([&] { pipeline.run(source); });

  advance(clock, 1);  // frame 0 is there
  entered.acquire();
  for (int k = 1; k <= 4; ++k) advance(clock, 10 * kMs);  // 1, 2, 3 and 4 come while 0 is held
  while (pipeline.counts().dropped < 3) std::this_thread::yield();
  opened.release();
  entered.acquire();  // it can only be 4
  opened.release(100);
  while (pipeline.counts().done < 2) std::this_thread::yield();
  for (int k = 5; k <= 9; ++k) {
    advance(clock, 10 * kMs);
    while (pipeline.counts().in < static_cast<std::uint64_t>(k) + 1 || pipeline.counts().in_flight > 0)
      std::this_thread::yield();
  }
  runner.join();

  ASSERT_EQ(delivered.size(), 7u);
  EXPECT_EQ(delivered[0].source_index, 0);
  EXPECT_EQ(delivered[1].source_index, 4);
  EXPECT_EQ(delivered[1].gap, 3u) << "the frame itself announces what was lost before it";
  EXPECT_EQ(delivered[2].source_index, 5);
  EXPECT_EQ(delivered[2].gap, 0u);
  const Counts counts = pipeline.counts();
  EXPECT_EQ(counts.in, 10u);
  EXPECT_EQ(counts.dropped_by[static_cast<std::size_t>(DropReason::replaced)], 3u);
  EXPECT_EQ(counts.done, 7u);
}

TEST(Live, DropsNothingWhileTheStagesKeepUp) {
  ManualClock clock;
  PipelineOptions options = workers(2);
  options.admission = Admission::live;
  Pipeline<Numbers> pipeline(options, clock);
  std::vector<Delivered> delivered;
  pipeline.source(writes(&Numbers::input));
  pipeline.add("square", reads(&Numbers::input), writes(&Numbers::sum), Square{}, parallel);
  pipeline.deliver(collect(delivered));
  Counting source(100, {}, kMs);
  std::jthread runner([&] { pipeline.run(source); });
  for (std::uint64_t k = 0; k < 100; ++k) {
    advance(clock, k == 0 ? 1 : kMs);
    while (pipeline.counts().done < k + 1) std::this_thread::yield();
  }
  runner.join();
  EXPECT_EQ(delivered.size(), 100u);
  EXPECT_EQ(pipeline.counts().dropped, 0u);
}

TEST(Live, StopsWhileItWaitsForAFrame) {
  ManualClock clock;
  PipelineOptions options = workers(1);
  options.admission = Admission::live;
  Pipeline<Numbers> pipeline(options, clock);
  pipeline.source(writes(&Numbers::input));
  pipeline.add("square", reads(&Numbers::input), writes(&Numbers::sum), Square{}, parallel);
  pipeline.prepare();
  Counting source(100, {}, kMs);
  std::jthread runner([&] { pipeline.run(source); });
  while (clock.sleepers() == 0) std::this_thread::yield();
  pipeline.stop();
  runner.join();
  EXPECT_EQ(pipeline.counts().in, 0u);
}

// The largest age at delivery, when each frame takes 20 ms and one comes every 10 ms, for a minute of the virtual
// clock.
struct Overload {
  std::int64_t oldest_ns = 0, last_age_ns = 0;
  Counts counts;
};
Overload at_twice_the_rate(Admission admission) {
  ManualClock clock(100 * kMs);
  PipelineOptions options = workers(1);
  options.admission = admission;
  Pipeline<Numbers> pipeline(options, clock);
  Overload seen;
  std::int64_t last = -1;
  pipeline.source(writes(&Numbers::input));
  pipeline.add("slow", reads(&Numbers::input), writes(&Numbers::sum), Takes{clock, 20 * kMs}, in_order);
  pipeline.deliver([&](const Numbers&, const FrameInfo& info, const Outcome&) {
    EXPECT_GT(info.source_index, last);
    EXPECT_EQ(info.gap, static_cast<std::uint64_t>(info.source_index - last - 1)) << "each frame tells what it lost";
    last = info.source_index;
    seen.last_age_ns = clock.now_ns() - info.t_sensor_ns;
    seen.oldest_ns = std::max(seen.oldest_ns, seen.last_age_ns);
  });
  Counting source(6000, {}, 10 * kMs);
  pipeline.run(source);
  seen.counts = pipeline.counts();
  return seen;
}

TEST(Live, AtTwiceTheRateTheAgeStaysFlatForAMinuteAndDropsAreCounted) {
  const Overload live = at_twice_the_rate(Admission::live);
  // Waiting for the worker to finish those before it (2 credits), its own 20 ms, and the first frames' head start.
  EXPECT_LE(live.oldest_ns, 160 * kMs);
  EXPECT_EQ(live.counts.in, 6000u);
  EXPECT_EQ(live.counts.dropped, live.counts.dropped_by[static_cast<std::size_t>(DropReason::replaced)]);
  EXPECT_GT(live.counts.dropped, 2000u);
  EXPECT_EQ(live.counts.in, live.counts.done + live.counts.dropped);
  const Overload queue = at_twice_the_rate(Admission::every_frame);
  EXPECT_GT(queue.last_age_ns, 50'000 * kMs) << "a queue's age grows as long as it lasts";
  EXPECT_EQ(queue.counts.dropped, 0u);
}

TEST(Pushed, FramesAreAdmittedOneByOne) {
  SteadyClock clock;
  Pipeline<Numbers> pipeline(workers(2), clock);
  std::vector<Delivered> delivered;
  pipeline.source(writes(&Numbers::input));
  pipeline.add("square", reads(&Numbers::input), writes(&Numbers::sum), Square{}, parallel);
  pipeline.deliver(collect(delivered));
  pipeline.start();
  for (std::int64_t i = 0; i < 50; ++i)
    EXPECT_TRUE(pipeline.admit([&](FrameInfo& info, Numbers& frame) { frame.input = info.source_index = i; }));
  pipeline.finish();
  ASSERT_EQ(delivered.size(), 50u);
  for (std::int64_t i = 0; i < 50; ++i) EXPECT_EQ(delivered[i].sum, i * i);
}

TEST(Pushed, APipelineThatIsNeverFinishedEndsCleanly) {
  SteadyClock clock;
  Pipeline<Numbers> pipeline(workers(2), clock);
  pipeline.source(writes(&Numbers::input));
  pipeline.add("square", reads(&Numbers::input), writes(&Numbers::sum), Square{}, parallel);
  pipeline.start();
  pipeline.admit([](FrameInfo&, Numbers& frame) { frame.input = 1; });
}

}  // namespace
}  // namespace pavo::test
