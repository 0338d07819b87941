// The engine's idle workers as the hands of a loop inside a stage.
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdint>

#include "engine/pipeline.h"
#include "types/spread.h"

namespace pavo {

/// For the stages of one pipeline, which must outlive it.
template <class Frame>
class WorkersSpread final : public Spread {
 public:
  WorkersSpread(Pipeline<Frame>& pipeline, int workers)
      : pipeline_(pipeline), hands_(std::clamp(workers + 1, 1, kMostHands)) {}  // one more: a relief worker
  int hands() const override { return hands_; }

 private:
  static constexpr int kMostHands = 32;

  void run(int turns, void* context, Call call) override {
    // Hands that are free, as bits: the engine's loops do not say who makes a turn.
    std::atomic<std::uint32_t> free{hands_ == kMostHands ? ~std::uint32_t{0} : (std::uint32_t{1} << hands_) - 1};
    pipeline_.share(turns, [&](int i) {
      const Lease lease(free);
      call(context, lease.hand, i);
    });
  }

  struct Lease {
    explicit Lease(std::atomic<std::uint32_t>& all) : free(all) {
      std::uint32_t bits = free.load();
      while (bits == 0 || !free.compare_exchange_weak(bits, bits & (bits - 1))) {
        if (bits == 0) free.wait(0);  // more workers than hands
        bits = free.load();
      }
      hand = std::countr_zero(bits);
    }
    ~Lease() {
      free.fetch_or(std::uint32_t{1} << hand);
      free.notify_one();
    }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    std::atomic<std::uint32_t>& free;
    int hand = 0;
  };

  Pipeline<Frame>& pipeline_;
  int hands_;
};

}  // namespace pavo
