// TBB's threads as the hands of a loop, for callers that are not the engine.
#pragma once

#include <atomic>

#include "stages/people/parallel_for.h"
#include "types/spread.h"

namespace pavo {

/// The arena's threads, of which the caller is one. The arena must outlive it.
class ArenaSpread final : public Spread {
 public:
  explicit ArenaSpread(tbb::task_arena& arena) : arena_(arena) {}
  int hands() const override { return arena_.max_concurrency(); }

 private:
  void run(int turns, void* context, Call call) override {
    std::atomic<int> next{0};
    parallel_for(arena_, hands(), [&](int hand) {
      for (int i = next++; i < turns; i = next++) call(context, hand, i);
    });
  }

  tbb::task_arena& arena_;
};

}  // namespace pavo
