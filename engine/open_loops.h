// Loops inside a stage, whose turns are made by whoever has nothing else to do.
#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>

#include "engine/clock.h"
#include "engine/event_count.h"
#include "engine/short_wait.h"

namespace pavo {

/// As many loops as there are workers, each open while somebody is in run(). A turn is claimed by one compare-and-swap;
/// the owner of the loop stays until the last one is made, so what it refers to is there. Loops have a rank, the
/// smaller the more urgent. Allocates nothing.
class OpenLoops {
 public:
  static constexpr int kMaxTurns = (1 << 16) - 1;
  static constexpr int kNone = std::numeric_limits<int>::max();  ///< the rank of no loop

  explicit OpenLoops(int workers)
      : loops_(std::make_unique<Loop[]>(static_cast<std::size_t>(workers))), count_(workers) {}

  /// turn(i) for every i in [0, n), by the caller and those who help(), in no order. `wake(k)` is to wake up to k
  /// sleeping helpers. Throws what a turn threw. n <= kMaxTurns.
  template <class Turn, class Wake>
  void run(int rank, int n, const Turn& turn, Wake&& wake) {
    Loop* loop = n > 1 && n <= kMaxTurns ? claim() : nullptr;
    if (!loop) {
      for (int i = 0; i < n; ++i) turn(i);
      return;
    }
    loop->turn = [](const void* t, int i) { (*static_cast<const Turn*>(t))(i); };
    loop->argument = &turn;
    loop->made.store(0);
    loop->error = nullptr;
    loop->rank.store(rank, std::memory_order_relaxed);
    loop->state.store(pack(++loop->generation, n, 0));
    wake(n - 1);
    while (make_a_turn(*loop)) {
    }
    wait_for_helpers(*loop, n);
    const std::exception_ptr error = std::exchange(loop->error, nullptr);
    loop->taken.store(false);
    if (error) std::rethrow_exception(error);
  }

  /// Of the most urgent open loop, or kNone.
  int rank() const {
    const Loop* loop = most_urgent();
    return loop ? loop->rank.load(std::memory_order_relaxed) : kNone;
  }
  /// Makes one turn of the most urgent open loop; false: there is none (any more).
  bool help() {
    Loop* loop = most_urgent();
    return loop && make_a_turn(*loop);
  }
  bool any() const { return most_urgent() != nullptr; }

 private:
  struct Loop {
    alignas(64) std::atomic<std::uint64_t> state{0};  ///< generation, number of turns, next turn
    std::atomic<bool> taken{false};
    std::atomic<int> rank{kNone};  ///< a loop that opened since it was read is of another: an error of no consequence
    std::atomic<int> made{0};
    EventCount all_made;
    ShortWait patience;  ///< the owner's
    std::uint32_t generation = 0;
    void (*turn)(const void*, int) = nullptr;
    const void* argument = nullptr;
    std::mutex error_mutex;
    std::exception_ptr error;
  };

  Loop* claim() {
    for (int l = 0; l < count_; ++l)
      if (!loops_[l].taken.load() && !loops_[l].taken.exchange(true)) return &loops_[l];
    return nullptr;
  }
  Loop* most_urgent() const {
    Loop* urgent = nullptr;
    for (int l = 0; l < count_; ++l)
      if (const std::uint64_t s = loops_[l].state.load(); next_of(s) < turns_of(s))
        if (!urgent || loops_[l].rank.load(std::memory_order_relaxed) < urgent->rank.load(std::memory_order_relaxed))
          urgent = &loops_[l];
    return urgent;
  }
  static std::uint64_t pack(std::uint32_t generation, int turns, int next) {
    return std::uint64_t{generation} << 32 | static_cast<std::uint64_t>(turns) << 16 | static_cast<std::uint64_t>(next);
  }
  static int turns_of(std::uint64_t state) { return static_cast<int>(state >> 16 & 0xffff); }
  static int next_of(std::uint64_t state) { return static_cast<int>(state & 0xffff); }

  static bool make_a_turn(Loop& loop) {
    std::uint64_t state = loop.state.load();
    do {
      if (next_of(state) >= turns_of(state)) return false;
    } while (!loop.state.compare_exchange_weak(state, state + 1));
    try {
      loop.turn(loop.argument, next_of(state));
    } catch (...) {
      const std::lock_guard lock(loop.error_mutex);
      if (!loop.error) loop.error = std::current_exception();
    }
    // Behind the last of these the owner may open its next loop: nothing of this one is touched any more but the event.
    if (loop.made.fetch_add(1) + 1 == turns_of(state)) loop.all_made.notify_one();
    return true;
  }

  static void wait_for_helpers(Loop& loop, int n) {
    if (loop.patience.look([&] { return loop.made.load() == n; })) return;
    const SteadyClock clock;
    const std::int64_t start = clock.now_ns();
    while (loop.made.load() != n) {
      const EventCount::Key key = loop.all_made.prepare();
      if (loop.made.load() == n)
        loop.all_made.cancel();
      else
        loop.all_made.wait(key);
    }
    loop.patience.slept(clock.now_ns() - start);
  }

  std::unique_ptr<Loop[]> loops_;
  int count_;
};

}  // namespace pavo
