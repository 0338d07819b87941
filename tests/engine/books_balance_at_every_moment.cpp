#include <gtest/gtest.h>

#include <random>

#include "tests/engine/numbers.h"

namespace pavo::test {
namespace {

struct Unreliable {
  std::uint64_t seed;
  void operator()(const FrameInfo& info, const std::int64_t& in, std::int64_t& out) const {
    std::mt19937_64 random(seed + info.sequence);
    const std::uint64_t r = random();
    for (std::uint64_t i = 0; i < r % 512; ++i) random();
    if (r % 11 == 0) throw std::runtime_error("bad luck");
    out = in;
  }
};

// Random failures, random stage times, random number of workers, stopped at a random moment, watched all the while.
void one_round(std::uint64_t seed, std::int64_t frames, std::uint64_t& total) {
  std::mt19937_64 random(seed);
  SteadyClock clock;
  PipelineOptions options = workers(1 + static_cast<int>(random() % 4));
  options.slots = 2 + static_cast<int>(random() % 8);
  options.failures_in_a_row = 1000;
  Pipeline<Numbers> pipeline(options, clock);
  Sum sum;
  std::vector<Delivered> delivered;
  pipeline.source(writes(&Numbers::input));
  pipeline.add("square", reads(&Numbers::input), writes(&Numbers::squared), Unreliable{seed}, parallel);
  pipeline.add("double", reads(&Numbers::input), writes(&Numbers::doubled), Unreliable{seed + 1}, parallel);
  pipeline.add("sum", reads(&Numbers::squared, &Numbers::doubled), writes(&Numbers::sum), std::ref(sum), in_order);
  pipeline.deliver(collect(delivered));
  pipeline.prepare();

  const std::uint64_t stop_at = random() % (2 * static_cast<std::uint64_t>(frames));
  std::atomic<std::uint64_t> looks = 0;
  std::jthread watcher([&](std::stop_token done) {
    while (!done.stop_requested()) {
      const Counts c = pipeline.counts();
      ASSERT_EQ(c.in, c.done + c.failed + c.dropped + c.in_flight);
      ASSERT_LE(c.in_flight, static_cast<std::uint64_t>(options.slots));
      if (c.in >= stop_at) pipeline.stop();
      ++looks;
    }
  });
  while (looks == 0) std::this_thread::yield();
  Counting source(frames);
  pipeline.run(source);
  watcher.request_stop();
  watcher.join();

  const Counts end = pipeline.counts();
  EXPECT_EQ(end.in_flight, 0u);
  EXPECT_EQ(end.in, end.done + end.failed);
  EXPECT_EQ(delivered.size(), end.in);
  for (std::uint64_t i = 0; i < delivered.size(); ++i)
    ASSERT_EQ(delivered[i].source_index, static_cast<std::int64_t>(i));
  EXPECT_EQ(sum.seen.size() + sum.missing.size(), end.in);
  EXPECT_GT(looks, 0u);
  total += end.in;
}

TEST(Books, BalanceUnderRandomFailuresAndAStopAtARandomMoment) {
  std::uint64_t frames = 0;
  for (std::uint64_t seed = 1; frames < 100'000; ++seed) one_round(seed, 4000, frames);
}

}  // namespace
}  // namespace pavo::test
