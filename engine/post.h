// What a thread is at, for whoever watches it.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <thread>

namespace pavo {

/// enter() and leave() are the thread's own, three stores and one; held() is anybody's.
class Post {
 public:
  struct Held {
    std::size_t node;
    std::uint64_t sequence;
    std::int64_t since_ns;
  };

  void enter(std::size_t node, std::uint64_t sequence, std::int64_t now_ns) {
    node_.store(node, std::memory_order_relaxed);
    sequence_.store(sequence, std::memory_order_relaxed);
    since_ns_.store(now_ns, std::memory_order_release);
  }
  /// The thread's own, before its first call.
  void occupy() { owner_.store(std::this_thread::get_id(), std::memory_order_relaxed); }
  /// Whether it is the calling thread's; then node() is what it is at, or was at last.
  bool is_mine() const { return owner_.load(std::memory_order_relaxed) == std::this_thread::get_id(); }
  std::size_t node() const { return node_.load(std::memory_order_relaxed); }
  void leave() { since_ns_.store(kFree, std::memory_order_release); }

  std::optional<Held> held() const {
    const std::int64_t since = since_ns_.load(std::memory_order_acquire);
    const Held held{node_.load(std::memory_order_acquire), sequence_.load(std::memory_order_acquire), since};
    if (since == kFree || since_ns_.load(std::memory_order_acquire) != since) return std::nullopt;
    return held;
  }

 private:
  static constexpr std::int64_t kFree = INT64_MIN;

  alignas(64) std::atomic<std::int64_t> since_ns_{kFree};
  std::atomic<std::uint64_t> sequence_{0};
  std::atomic<std::size_t> node_{0};
  std::atomic<std::thread::id> owner_{};
};

}  // namespace pavo
