// Loops inside a stage: turns are made once each, by whoever has nothing to do, and what they throw comes back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <set>
#include <thread>

#include "tests/engine/numbers.h"

namespace pavo::test {
namespace {

// Sums 1..in by turns of a shared loop, each into a place of its own.
struct SharedSum {
  Pipeline<Numbers>& pipeline;
  int turns;
  void operator()(const std::int64_t& in, std::int64_t& out) const {
    std::vector<std::int64_t> parts(static_cast<std::size_t>(turns));
    pipeline.share(turns, [&](int t) {
      for (std::int64_t i = t; i <= in; i += turns) parts[static_cast<std::size_t>(t)] += i;
    });
    out = std::accumulate(parts.begin(), parts.end(), std::int64_t{0});
  }
};

TEST(SharedLoop, GivesTheSameWithAnyNumberOfWorkers) {
  for (const int n : {1, 2, 3, 4, 8})
    for (const int turns : {0, 1, 2, 7, 100}) {
      SteadyClock clock;
      Pipeline<Numbers> pipeline(workers(n), clock);
      std::vector<Delivered> delivered;
      pipeline.source(writes(&Numbers::input));
      pipeline.add("a", reads(&Numbers::input), writes(&Numbers::squared), SharedSum{pipeline, turns}, parallel);
      pipeline.add("b", reads(&Numbers::input), writes(&Numbers::sum), SharedSum{pipeline, turns}, parallel);
      pipeline.deliver(collect(delivered));
      Counting source(60);
      pipeline.run(source);
      ASSERT_EQ(delivered.size(), 60u);
      for (std::int64_t k = 0; k < 60; ++k) EXPECT_EQ(delivered[k].sum, turns == 0 ? 0 : k * (k + 1) / 2);
    }
}

TEST(SharedLoop, IsSharedWithAWorkerThatHasNothingToDo) {
  SteadyClock clock;
  Pipeline<Numbers> pipeline(workers(2), clock);
  std::mutex mutex;
  std::set<std::thread::id> who;
  std::atomic<int> inside{0};
  pipeline.source(writes(&Numbers::input));
  pipeline.add(
      "together", reads(&Numbers::input), writes(&Numbers::sum),
      [&](const std::int64_t& in, std::int64_t& out) {
        pipeline.share(2, [&](int) {
          ++inside;
          while (inside < 2) std::this_thread::yield();  // both are here at the same time
          const std::lock_guard lock(mutex);
          who.insert(std::this_thread::get_id());
        });
        out = in;
      },
      parallel);
  Counting source(1);
  pipeline.run(source);
  EXPECT_EQ(who.size(), 2u);
}

TEST(SharedLoop, NearerToTheDeliveryComesBeforeANewFrame) {
  SteadyClock clock;
  Pipeline<Numbers> pipeline(workers(2), clock);
  std::atomic<bool> open{false};
  std::atomic<int> inside{0}, helped_at{0}, begun_at{0}, now{0};
  struct Near {
    std::function<void(std::int64_t)> work;
    void operator()(const std::int64_t& in, std::int64_t& out) {
      work(in);
      out = in;
    }
    void missed(std::int64_t&) {}
  };
  pipeline.source(writes(&Numbers::input));
  pipeline.add(
      "far", reads(&Numbers::input), writes(&Numbers::squared),
      [&](const std::int64_t& in, std::int64_t& out) {
        while (in == 1 && !(open && pipeline.counts().in > 3)) std::this_thread::yield();  // frame 2 is waiting
        if (in == 2) begun_at = ++now;
        out = in;
      },
      parallel);
  pipeline.add("near", reads(&Numbers::squared), writes(&Numbers::sum), Near{[&](std::int64_t in) {
                 if (in > 0) return;
                 const auto owner = std::this_thread::get_id();
                 pipeline.share(2, [&](int) {
                   open = true;
                   if (std::this_thread::get_id() != owner) helped_at = ++now;
                   ++inside;
                   while (inside < 2) std::this_thread::yield();
                 });
               }},
               in_order);
  Counting source(6);
  pipeline.run(source);
  EXPECT_EQ(helped_at, 1);
  EXPECT_EQ(begun_at, 2);
}

TEST(SharedLoop, ThatThrowsFailsItsFrameOnly) {
  SteadyClock clock;
  Pipeline<Numbers> pipeline(workers(3), clock);
  std::vector<Delivered> delivered;
  pipeline.source(writes(&Numbers::input));
  pipeline.add(
      "fragile", reads(&Numbers::input), writes(&Numbers::sum),
      [&](const std::int64_t& in, std::int64_t& out) {
        std::atomic<std::int64_t> made{0};
        pipeline.share(10, [&](int t) {
          if (in % 5 == 3 && t == 4) throw std::runtime_error("turn 4");
          ++made;
        });
        out = made;
      },
      parallel);
  pipeline.deliver(collect(delivered));
  Counting source(100);
  pipeline.run(source);
  for (std::int64_t k = 0; k < 100; ++k) {
    EXPECT_EQ(delivered[k].failed, k % 5 == 3);
    EXPECT_EQ(delivered[k].message, k % 5 == 3 ? "turn 4" : "");
  }
}

}  // namespace
}  // namespace pavo::test
