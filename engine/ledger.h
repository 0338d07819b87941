// The books: in = done + dropped + failed + in flight, whenever one looks.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string_view>

namespace pavo {

enum class DropReason {
  replaced,  ///< live: a newer frame came before this one could be admitted
  stale,     ///< live: a device gave its buffer back unread, since a newer frame came
  stopped,   ///< it had been read when the run was stopped
};
inline constexpr std::array<std::string_view, 3> kDropReasons{"replaced", "stale", "stopped"};

struct Counts {
  std::uint64_t in = 0;  ///< every frame that was read or dequeued
  std::uint64_t done = 0;
  std::uint64_t failed = 0;
  std::uint64_t dropped = 0;
  std::uint64_t in_flight = 0;    ///< counted from the slots' states
  std::uint64_t lost_before = 0;  ///< frames that the driver itself lost; not part of `in`
  std::array<std::uint64_t, kDropReasons.size()> dropped_by{};
};

/// Two writers, each of which only one thread plays at a time: the admission, and the (in-order) delivery. They never
/// wait. snapshot() may be called by anybody at any time; it reads again until both have held still (two sequence
/// locks, made of sequentially consistent atomics, which the thread sanitizer understands).
class Ledger {
 public:
  explicit Ledger(int slots) : in_flight_(std::make_unique<std::atomic<bool>[]>(slots)), slots_(slots) {}

  void admitted(int slot, std::uint64_t lost_before) {
    const Writing writing(admission_);
    in_.fetch_add(1);
    lost_before_.fetch_add(lost_before);
    in_flight_[slot].store(true);
  }
  void dropped(DropReason reason, std::uint64_t count) {
    const Writing writing(admission_);
    in_.fetch_add(count);
    dropped_[static_cast<std::size_t>(reason)].fetch_add(count);
  }
  void delivered(int slot, bool failed) {
    const Writing writing(delivery_);
    (failed ? failed_ : done_).fetch_add(1);
    in_flight_[slot].store(false);
  }

  Counts snapshot() const {
    for (;;) {
      const std::uint64_t a = admission_.load(), d = delivery_.load();
      const Counts counts = read();
      if (a % 2 == 0 && d % 2 == 0 && admission_.load() == a && delivery_.load() == d) return counts;
    }
  }

 private:
  struct Writing {
    explicit Writing(std::atomic<std::uint64_t>& v) : version(v) { version.fetch_add(1); }
    ~Writing() { version.fetch_add(1); }
    Writing(const Writing&) = delete;
    Writing& operator=(const Writing&) = delete;
    std::atomic<std::uint64_t>& version;
  };

  Counts read() const {
    Counts c{.in = in_.load(), .done = done_.load(), .failed = failed_.load(), .lost_before = lost_before_.load()};
    for (std::size_t r = 0; r < dropped_.size(); ++r) c.dropped += c.dropped_by[r] = dropped_[r].load();
    for (int s = 0; s < slots_; ++s) c.in_flight += in_flight_[s].load() ? 1 : 0;
    return c;
  }

  std::atomic<std::uint64_t> admission_{0}, in_{0}, lost_before_{0};
  std::array<std::atomic<std::uint64_t>, kDropReasons.size()> dropped_{};
  alignas(64) std::atomic<std::uint64_t> delivery_{0};
  std::atomic<std::uint64_t> done_{0}, failed_{0};
  std::unique_ptr<std::atomic<bool>[]> in_flight_;
  int slots_;
};

}  // namespace pavo
