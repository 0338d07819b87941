#include "engine/clock.h"

#include <algorithm>
#include <ctime>

namespace pavo {
namespace {

std::int64_t read_clock(clockid_t id) {
  timespec t{};
  clock_gettime(id, &t);
  return static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

}  // namespace

std::int64_t SteadyClock::now_ns() const {
  return read_clock(CLOCK_MONOTONIC);
}

void SteadyClock::wait(EventCount& event, EventCount::Key key, std::int64_t deadline_ns) {
  event.wait_until(key, deadline_ns);
}

void ManualClock::wait(EventCount& event, EventCount::Key key, std::int64_t deadline_ns) {
  {
    std::lock_guard lock(mutex_);
    if (now_ns_.load() >= deadline_ns) return event.cancel();
    waiting_.push_back(&event);
  }
  event.wait(key);
  std::lock_guard lock(mutex_);
  waiting_.erase(std::find(waiting_.begin(), waiting_.end(), &event));
}

void ManualClock::advance(std::int64_t by_ns) {
  std::lock_guard lock(mutex_);
  now_ns_.fetch_add(by_ns);
  // Whoever sleeps has announced itself before it registered here, so no wake-up is lost.
  for (EventCount* event : waiting_) event->notify_all();
}

int ManualClock::sleepers() const {
  std::lock_guard lock(mutex_);
  return static_cast<int>(waiting_.size());
}

std::int64_t thread_cpu_ns() {
  return read_clock(CLOCK_THREAD_CPUTIME_ID);
}

}  // namespace pavo
