// Events on their way from the thread that sees them to the thread that writes them down.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

namespace pavo {

/// A ring for one writing and one reading thread. Nobody waits, nothing is allocated: what finds no room is counted as
/// lost. (Every thread of the engine has its own, so nothing wider than this is needed: moodycamel::ConcurrentQueue
/// would be, for many writers, but its fences are invisible to the thread sanitizer.)
template <class T>
class EventRing {
 public:
  explicit EventRing(std::size_t capacity) : ring_(capacity) {}

  // --- the writer
  void put(const T& event) {
    const std::uint64_t at = written_.load(std::memory_order_relaxed);
    if (at - seen_read_ == ring_.size()) {
      seen_read_ = read_.load(std::memory_order_acquire);
      if (at - seen_read_ == ring_.size()) {
        lost_.fetch_add(1, std::memory_order_relaxed);
        return;
      }
    }
    ring_[at % ring_.size()] = event;
    written_.store(at + 1, std::memory_order_release);
  }

  // --- the reader
  /// use(event) for all that is there.
  template <class Use>
  void drain(Use&& use) {
    const std::uint64_t end = written_.load(std::memory_order_acquire);
    for (std::uint64_t at = read_.load(std::memory_order_relaxed); at != end; ++at) {
      use(ring_[at % ring_.size()]);
      read_.store(at + 1, std::memory_order_release);
    }
  }
  std::uint64_t lost() const { return lost_.load(std::memory_order_relaxed); }

 private:
  std::vector<T> ring_;
  alignas(64) std::atomic<std::uint64_t> written_{0};
  std::uint64_t seen_read_ = 0;  // the writer's own
  std::atomic<std::uint64_t> lost_{0};
  alignas(64) std::atomic<std::uint64_t> read_{0};
};

}  // namespace pavo
