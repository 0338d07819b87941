// The tokens that wait for one stage.
#pragma once

#include <atomic>
#include <bit>
#include <cstdint>
#include <optional>

namespace pavo {

/// A set of slots, as bits of one word: a token is the index of a slot, and there are at most 32. Bounded by nature,
/// so nothing can be refused; takes the oldest frame first, whoever put it in; one atomic operation each way.
/// (moodycamel::ConcurrentQueue is unordered across its producers and may refuse an item while it has room; see
/// bench/edges for both, side by side.) Any number of threads; wait-free put, lock-free take; never allocates.
class ReadySet {
 public:
  static constexpr int kMaxSlots = 32;

  void put(int slot) { bits_.fetch_or(std::uint32_t{1} << slot); }
  bool empty() const { return bits_.load() == 0; }
  int size() const { return std::popcount(bits_.load()); }

  /// The oldest token, where slots are reused in ring order and `oldest_slot` holds the oldest frame in flight.
  std::optional<int> take(int oldest_slot) {
    std::uint32_t bits = bits_.load();
    while (bits != 0) {
      const std::uint32_t from_oldest = bits & (~std::uint32_t{0} << oldest_slot);
      const int slot = std::countr_zero(from_oldest != 0 ? from_oldest : bits);
      if (bits_.compare_exchange_weak(bits, bits & ~(std::uint32_t{1} << slot))) return slot;
    }
    return std::nullopt;
  }

 private:
  alignas(64) std::atomic<std::uint32_t> bits_{0};
};

}  // namespace pavo
