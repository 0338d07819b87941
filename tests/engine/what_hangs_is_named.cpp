// The watchdog: who hangs is named, and all that was before it comes out first.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <semaphore>

#include "tests/engine/numbers.h"

namespace pavo::test {
namespace {

constexpr std::int64_t kLimit_ns = 2'500'000'000;

// A stage or a source that hangs at one number until the test lets it go.
struct Trap {
  std::int64_t number;
  std::atomic<bool> caught{false};
  std::binary_semaphore open{0};
  void step_on(std::int64_t n) {
    if (n != number) return;
    caught = true;
    open.acquire();
  }
};

/// In order: hands on what it reads.
struct TrappedCopy {
  Trap& trap;
  void operator()(const std::int64_t& in, std::int64_t& out) {
    trap.step_on(in);
    out = in;
  }
  void missed(std::int64_t&) {}
};

struct TrappedSource : Counting {
  TrappedSource(std::int64_t count, Trap& t) : Counting(count), trap(t) {}
  bool read(FrameInfo& info, Numbers& frame) override {
    const bool there = Counting::read(info, frame);
    if (there) trap.step_on(frame.input);
    return there;
  }
  Trap& trap;
};

// Whoever still holds a frame before the trapped one when the virtual clock goes on is overdue, too.
template <class Frame>
void wait_until_all_before_is_out(const Pipeline<Frame>& pipeline, std::int64_t number) {
  while (pipeline.counts().done < static_cast<std::uint64_t>(number)) std::this_thread::yield();
}

struct Hang {
  HungStage told;
  std::size_t delivered_before = 0;
  std::string thrown;
  std::size_t delivered = 0;
};

enum class Where { source, parallel_stage, in_order_stage, delivery };

// Runs into the trap, lets the limit pass, and opens the trap when the hang was told.
Hang run_into(Where where, int workers_count, std::int64_t number) {
  ManualClock clock;
  PipelineOptions options = workers(workers_count);
  options.stage_limit_ns = options.source_limit_ns = kLimit_ns;
  Pipeline<Numbers> pipeline(options, clock);
  Trap trap{number}, none{-1};
  const auto trap_in = [&](Where w) -> Trap& { return w == where ? trap : none; };
  pipeline.source(writes(&Numbers::input));
  pipeline.add(
      "square", reads(&Numbers::input), writes(&Numbers::squared),
      [&t = trap_in(Where::parallel_stage)](const std::int64_t& in, std::int64_t& out) {
        t.step_on(in);
        out = in;
      },
      parallel);
  pipeline.add("sum", reads(&Numbers::squared), writes(&Numbers::sum), TrappedCopy{trap_in(Where::in_order_stage)},
               in_order);
  Hang hang;
  std::atomic<std::size_t> delivered{0};
  pipeline.deliver([&](const Numbers& frame, const FrameInfo&, const Outcome&) {
    trap_in(Where::delivery).step_on(frame.input);
    ++delivered;
  });
  pipeline.prepare();
  std::binary_semaphore told{0};
  pipeline.on_hang([&](const HungStage& hung) {
    hang.told = hung;
    hang.delivered_before = delivered;
    told.release();
  });
  std::jthread runner([&] {
    TrappedSource source(100'000, trap_in(Where::source));
    try {
      pipeline.run(source);
    } catch (const RunError& e) {
      hang.thrown = e.what();
    }
  });
  while (!trap.caught) std::this_thread::yield();
  wait_until_all_before_is_out(pipeline, number);
  clock.advance(kLimit_ns - 1);  // not yet
  for (int i = 0; i < 100; ++i) std::this_thread::yield();
  EXPECT_EQ(hang.told.stage, "");
  while (!told.try_acquire()) {
    clock.advance(1);
    std::this_thread::yield();
  }
  trap.open.release();
  runner.join();
  hang.delivered = delivered;
  return hang;
}

TEST(Watchdog, NamesAParallelStageWhenAllBeforeItIsDelivered) {
  for (const int n : {1, 2, 4}) {
    const Hang hang = run_into(Where::parallel_stage, n, 20);
    EXPECT_EQ(hang.told.stage, "square");
    EXPECT_EQ(hang.told.frame, 20u);
    EXPECT_EQ(hang.told.message, "stage 'square' has held frame 20 for more than 2.500 s: it hangs");
    EXPECT_EQ(hang.delivered_before, 20u) << n << " workers";
    EXPECT_EQ(hang.delivered, 20u) << "nothing is delivered behind the end";
    EXPECT_EQ(hang.thrown, hang.told.message) << "should it come back";
  }
}

TEST(Watchdog, NamesAnInOrderStage) {
  for (const int n : {1, 3}) {
    const Hang hang = run_into(Where::in_order_stage, n, 7);
    EXPECT_EQ(hang.told.stage, "sum");
    EXPECT_EQ(hang.delivered_before, 7u);
  }
}

TEST(Watchdog, NamesTheSource) {
  const Hang hang = run_into(Where::source, 2, 11);
  EXPECT_EQ(hang.told.stage, "source");
  EXPECT_EQ(hang.told.message, "the source has not delivered frame 11 within 2.500 s: it hangs");
  EXPECT_EQ(hang.delivered_before, 11u);
}

TEST(Watchdog, NamesTheDelivery) {
  const Hang hang = run_into(Where::delivery, 2, 5);
  EXPECT_EQ(hang.told.stage, "delivery");
  EXPECT_EQ(hang.delivered_before, 5u);
}

TEST(Watchdog, LetsSlowStagesBe) {
  ManualClock clock;
  PipelineOptions options = workers(1);  // another's delivery would see the clock run on under it
  options.stage_limit_ns = kLimit_ns;
  Pipeline<Numbers> pipeline(options, clock);
  pipeline.source(writes(&Numbers::input));
  pipeline.add("slow", reads(&Numbers::input), writes(&Numbers::sum), Takes{clock, kLimit_ns - 1}, in_order);
  pipeline.prepare();
  pipeline.on_hang([](const HungStage& hung) { ADD_FAILURE() << hung.message; });
  Counting source(50);
  pipeline.run(source);
  EXPECT_EQ(pipeline.counts().done, 50u);
}

// The run is ended for a stage that is over its limit. Should it come back while frames before it are still on their
// way, all is delivered, and the run says all the same why there is no more: it may not look like a source that ended.
TEST(Watchdog, SaysWhyARunIsShortThatItEndedForAStageThatCameBack) {
  struct Interrupted : Counting {
    using Counting::Counting;
    void interrupt() override { stopped = true; }
    std::atomic<bool> stopped{false};
  };
  for (int round = 0; round < 20; ++round) {
    ManualClock clock;
    PipelineOptions options = workers(2);
    options.stage_limit_ns = kLimit_ns;
    Pipeline<Numbers> pipeline(options, clock);
    Trap before{19}, long_held{20}, held{19};
    pipeline.source(writes(&Numbers::input));
    pipeline.add(
        "square", reads(&Numbers::input), writes(&Numbers::squared),
        [&](const std::int64_t& in, std::int64_t& out) {
          before.step_on(in);
          long_held.step_on(in);
          out = in;
        },
        parallel);
    pipeline.add("sum", reads(&Numbers::squared), writes(&Numbers::sum), TrappedCopy{held}, in_order);
    std::size_t delivered = 0;
    pipeline.deliver([&](const Numbers&, const FrameInfo&, const Outcome&) { ++delivered; });
    pipeline.prepare();
    Interrupted source(100'000);
    std::string thrown;
    std::jthread runner([&] {
      try {
        pipeline.run(source);
      } catch (const RunError& e) {
        thrown = e.what();
      }
    });
    while (!before.caught || !long_held.caught) std::this_thread::yield();
    wait_until_all_before_is_out(pipeline, 19);
    clock.advance(kLimit_ns / 2);
    before.open.release();  // frame 19 is late, too, but not as late as 20
    while (!held.caught) std::this_thread::yield();
    clock.advance(kLimit_ns / 2);
    while (!source.stopped) std::this_thread::yield();
    long_held.open.release();
    held.open.release();
    runner.join();
    EXPECT_EQ(thrown, "stage 'square' has held frame 20 for more than 2.500 s: it hangs");
    EXPECT_GE(delivered, 20u);
  }
}

// A background stage that hangs at frame 9: when it takes over its inputs, on a worker, or behind the frames.
std::string hang_in_background(bool when_it_takes) {
  struct Revised {
    std::int64_t input = 0, estimate = 0;
    Delayed<std::int64_t> correction;
  };
  struct Copy {
    void operator()(const std::int64_t& in, const std::int64_t*, std::int64_t& out) { out = in; }
    void missed(const std::int64_t*, std::int64_t&) {}
  };
  struct Revise {
    struct Work {
      std::int64_t number = 0;
    };
    Trap& taking;
    Trap& working;
    bool take(const std::int64_t& in, Work& work) const {
      taking.step_on(in);
      work.number = in;
      return true;
    }
    void operator()(Work& work, std::int64_t& out) {
      working.step_on(work.number);
      out = work.number;
    }
  };
  ManualClock clock;
  PipelineOptions options = workers(2);
  options.stage_limit_ns = kLimit_ns;
  Pipeline<Revised> pipeline(options, clock);
  Trap trap{9}, none{-1};
  std::atomic<std::size_t> delivered{0};
  pipeline.source(writes(&Revised::input));
  pipeline.add("estimate", reads(&Revised::input, delayed<2>(&Revised::correction)), writes(&Revised::estimate), Copy{},
               in_order);
  pipeline.add("refine", reads(&Revised::estimate), writes(&Revised::correction),
               Revise{when_it_takes ? trap : none, when_it_takes ? none : trap}, background);
  pipeline.deliver([&](const Revised&, const FrameInfo&, const Outcome&) { ++delivered; });
  pipeline.start();
  std::string message;
  std::binary_semaphore told{0};
  pipeline.on_hang([&](const HungStage& hung) {
    message = hung.message;
    EXPECT_GE(delivered, 10u);
    told.release();
  });
  std::jthread pusher([&] {
    for (std::int64_t k = 0; k < 1000 && pipeline.admit([&](FrameInfo&, Revised& frame) { frame.input = k; }); ++k) {
    }
    EXPECT_THROW(pipeline.finish(), RunError);
  });
  while (!trap.caught) std::this_thread::yield();
  wait_until_all_before_is_out(pipeline, 11);  // the twelfth waits for what flows back
  while (!told.try_acquire()) {
    clock.advance(kLimit_ns / 2);
    std::this_thread::yield();
  }
  trap.open.release();
  pusher.join();
  return message;
}

TEST(Watchdog, NamesABackgroundStage) {
  for (const bool when_it_takes : {false, true})
    EXPECT_EQ(hang_in_background(when_it_takes), "stage 'refine' has held frame 9 for more than 2.500 s: it hangs");
}

}  // namespace
}  // namespace pavo::test
