#include <gtest/gtest.h>

#include <random>
#include <utility>

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
// Live, frames come by a virtual clock, which goes on while the admission waits for it: by some periods for each frame
// that comes out, however slowly the machine runs, so that frames are dropped and others are not. Returns what is in
// the books.
Counts one_round(std::uint64_t seed, std::int64_t frames, Admission admission) {
  constexpr std::int64_t kPeriod_ns = 16, kAhead_ns = 4 * kPeriod_ns;
  std::mt19937_64 random(seed);
  const bool live = admission == Admission::live;
  SteadyClock steady;
  ManualClock manual;
  Clock& clock = live ? static_cast<Clock&>(manual) : steady;
  PipelineOptions options = workers(1 + static_cast<int>(random() % 4));
  options.admission = admission;
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
    std::uint64_t out = 0;
    std::int64_t ahead_ns = 0;
    while (!done.stop_requested()) {
      const Counts c = pipeline.counts();
      const bool balance = c.in == c.done + c.failed + c.dropped + c.in_flight &&
                           c.in_flight <= static_cast<std::uint64_t>(options.slots);
      EXPECT_TRUE(balance) << c.in << " " << c.done << " " << c.failed << " " << c.dropped << " " << c.in_flight;
      if (c.in >= stop_at || !balance) pipeline.stop();
      if (std::exchange(out, c.done + c.failed) != c.done + c.failed) ahead_ns = 0;
      if (live && manual.sleepers() > 0 && ahead_ns < kAhead_ns) {
        const auto step_ns = 1 + static_cast<std::int64_t>(looks % 3);
        manual.advance(step_ns);
        ahead_ns += step_ns;
      }
      ++looks;
    }
  });
  while (looks == 0) std::this_thread::yield();
  Counting source(frames, {}, kPeriod_ns);
  pipeline.run(source);
  watcher.request_stop();
  watcher.join();

  const Counts end = pipeline.counts();
  EXPECT_EQ(end.in_flight, 0u);
  EXPECT_EQ(end.in, end.done + end.failed + end.dropped);
  EXPECT_EQ(delivered.size(), end.done + end.failed);
  std::int64_t next = 0;
  for (const Delivered& frame : delivered) {
    EXPECT_EQ(frame.source_index, next + static_cast<std::int64_t>(frame.gap)) << "what was dropped is announced";
    next = frame.source_index + 1;
  }
  EXPECT_EQ(sum.seen.size() + sum.missing.size(), delivered.size());
  EXPECT_GT(looks, 0u);
  return end;
}

TEST(Books, BalanceUnderRandomFailuresAndAStopAtARandomMoment) {
  for (std::uint64_t seed = 1, frames = 0; frames < 100'000; ++seed) {
    const Counts end = one_round(seed, 4000, Admission::every_frame);
    EXPECT_EQ(end.dropped, 0u);
    frames += end.in;
  }
}

TEST(Books, BalanceWhileFramesAreDropped) {
  std::uint64_t replaced = 0, done = 0;
  for (std::uint64_t seed = 1, frames = 0; frames < 50'000; ++seed) {
    const Counts end = one_round(seed, 1000, Admission::live);
    replaced += end.dropped_by[static_cast<std::size_t>(DropReason::replaced)];
    done += end.done;
    frames += end.in;
  }
  EXPECT_GT(replaced, 500u);
  EXPECT_GT(done, 500u);
}

}  // namespace
}  // namespace pavo::test
