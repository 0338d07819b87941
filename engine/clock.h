// Time as the engine sees it: injected, so that tests run on a clock that they turn themselves.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

#include "engine/event_count.h"

namespace pavo {

/// Nanoseconds of CLOCK_MONOTONIC, as V4L2 stamps its frames. Thread-safe, never allocates in now_ns().
class Clock {
 public:
  virtual ~Clock() = default;
  virtual std::int64_t now_ns() const = 0;
  /// Completes event.prepare(): sleeps until the event is notified after `key`, or the clock reaches `deadline_ns`.
  virtual void wait(EventCount& event, EventCount::Key key, std::int64_t deadline_ns) = 0;
};

/// The machine's own clock.
class SteadyClock final : public Clock {
 public:
  std::int64_t now_ns() const override;
  void wait(EventCount& event, EventCount::Key key, std::int64_t deadline_ns) override;
};

/// A clock that stands still until it is advanced.
class ManualClock final : public Clock {
 public:
  explicit ManualClock(std::int64_t start_ns = 0) : now_ns_(start_ns) {}
  std::int64_t now_ns() const override { return now_ns_.load(); }
  void wait(EventCount& event, EventCount::Key key, std::int64_t deadline_ns) override;
  void advance(std::int64_t by_ns);
  /// How many threads sleep until a later time: lets a test advance only when everybody is waiting for it.
  int sleepers() const;

 private:
  std::atomic<std::int64_t> now_ns_;
  mutable std::mutex mutex_;
  std::vector<EventCount*> waiting_;
};

/// CPU time that the calling thread has used. Costs about 0.4 us a call: sample it, do not call it per token.
std::int64_t thread_cpu_ns();

}  // namespace pavo
