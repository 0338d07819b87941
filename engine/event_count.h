// Sleeping on a futex until something happens, without a lock and without a lost wake-up.
#pragma once

#include <atomic>
#include <cstdint>

namespace pavo {

/// The event count of Vyukov and Kegel: who waits announces itself, looks once more, and only then sleeps.
///
///     waiter:    key = event.prepare();                notifier:  publish the work (seq_cst)
///                if (work there) event.cancel();                  event.notify_one();
///                else event.wait(key);
///
/// Correct because both sides are sequentially consistent: either the waiter sees the work, or the notifier sees the
/// waiter. Notifying costs one load while nobody sleeps. Thread-safe; never allocates; notify is async-signal-safe.
class EventCount {
 public:
  using Key = std::uint32_t;

  Key prepare() {
    sleepers_.fetch_add(1);
    return epoch_.load();
  }
  void cancel() { sleepers_.fetch_sub(1); }
  void wait(Key key);
  /// As wait(), but no longer than until CLOCK_MONOTONIC reaches `deadline_ns`.
  void wait_until(Key key, std::int64_t deadline_ns);

  void notify_one() { notify(1); }
  void notify_all();
  void notify(int count);

  /// How many sleep, or are about to: a moment's truth.
  int sleepers() const { return static_cast<int>(sleepers_.load()); }

 private:
  std::atomic<std::uint32_t> epoch_{0};
  std::atomic<std::uint32_t> sleepers_{0};
};

}  // namespace pavo
