#include "bench/pipeline/alone.h"

#include <algorithm>
#include <cstdio>
#include <utility>
#include <vector>

#include "bench/pipeline/competitors.h"
#include "engine/clock.h"

namespace pavo::bench {
namespace {

constexpr std::int64_t kFrames = 60, kWarmUp = 10;
constexpr double kRate_hz = 25;

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// Makes all turns itself, and knows how long they took: what others could have helped with.
class Stopwatch final : public Spread {
 public:
  int hands() const override { return 1; }
  double take_ms() { return std::exchange(ms_, 0); }

 private:
  void run(int turns, void* context, Call call) override {
    const std::int64_t start = clock_.now_ns();
    for (int i = 0; i < turns; ++i) call(context, 0, i);
    ms_ += static_cast<double>(clock_.now_ns() - start) * 1e-6;
  }
  SteadyClock clock_;
  double ms_ = 0;
};

// One thread's way of a frame: as a whole, and the part of it that could be spread over two cores.
struct Bound {
  std::vector<double> whole_ms, spread_ms, bound_ms;
};

// Stages 1 and 2 read the same and may run side by side; inside 2 and 4 there are loops to be shared.
void measure_bound(Work& work, Bound& bound) {
  Stopwatch turns;
  work.begin(1, &turns);
  Feed feed(kFrames, kRate_hz, kWarmUp);
  const SteadyClock clock;
  for (std::int64_t k; (k = feed.next()) >= 0;) {
    const std::int64_t start = clock.now_ns();
    work.load(k);
    work.stage(0, k);
    const std::int64_t features = clock.now_ns();
    work.stage(1, k);
    const double features_ms = static_cast<double>(clock.now_ns() - features) * 1e-6;
    for (int s = 2; s < Work::kStages; ++s) work.stage(s, k);
    const double whole_ms = static_cast<double>(clock.now_ns() - start) * 1e-6;
    feed.done(k);
    const double spread_ms = features_ms + turns.take_ms();
    if (k < kWarmUp) continue;
    bound.whole_ms.push_back(whole_ms);
    bound.spread_ms.push_back(spread_ms);
    bound.bound_ms.push_back(whole_ms - spread_ms / 2);
  }
}

}  // namespace

void measure_alone(Work& work, int rounds) {
  struct Entrant {
    Competitor competitor;
    int threads = 2;
    std::vector<double> p50_ms{};
  };
  const std::vector<int> two{2};
  std::vector<Entrant> entrants{
      {{"plain loop", run_plain_loop, 1, 1, two}},
      {{"tbb::parallel_pipeline, nested loops", run_tbb_pipeline_nested, 2, 8, two}, 3},  // one sleeps in the source
      {{"pavo", run_pavo, 2, 8, two}},
  };
  Bound bound;
  for (int round = 0; round < rounds; ++round) {
    measure_bound(work, bound);
    for (Entrant& e : entrants) {
      Feed feed(kFrames, kRate_hz, kWarmUp);
      e.competitor.run(work, feed, {e.competitor.least_tokens, e.threads});
      const std::vector<double> ms = feed.latencies_ms();
      e.p50_ms.push_back(ms[ms.size() / 2]);
    }
  }
  const double least = median(bound.bound_ms);
  std::printf("| a frame alone, %.0f a second | latency p50, ms | of the bound |\n| --- | --- | --- |\n", kRate_hz);
  for (const Entrant& e : entrants)
    std::printf("| %s | %.2f | %.2f |\n", e.competitor.name, median(e.p50_ms), median(e.p50_ms) / least);
  std::printf(
      "| the bound on two cores | %.2f | 1 |\n\nOf one thread's %.2f ms, %.2f may be spread (features beside the scan, "
      "its levels, the matching); the bound is the rest and half of that.\n",
      least, median(bound.whole_ms), median(bound.spread_ms));
}

}  // namespace pavo::bench
