#include "engine/event_count.h"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <climits>
#include <ctime>

namespace pavo {
namespace {

static_assert(sizeof(std::atomic<std::uint32_t>) == sizeof(std::uint32_t), "a futex is a plain 32-bit word");

// Returns at a wake-up, at once if the word is no longer `expected`, at the deadline, or spuriously: callers loop.
void futex_wait(std::atomic<std::uint32_t>& word, std::uint32_t expected, const timespec* deadline) {
  syscall(SYS_futex, &word, FUTEX_WAIT_BITSET_PRIVATE, expected, deadline, nullptr, FUTEX_BITSET_MATCH_ANY);
}

}  // namespace

void EventCount::wait(Key key) {
  while (epoch_.load() == key) futex_wait(epoch_, key, nullptr);
  sleepers_.fetch_sub(1);
}

void EventCount::wait_until(Key key, std::int64_t deadline_ns) {
  const timespec deadline{.tv_sec = deadline_ns / 1'000'000'000, .tv_nsec = deadline_ns % 1'000'000'000};
  if (epoch_.load() == key) futex_wait(epoch_, key, &deadline);
  sleepers_.fetch_sub(1);
}

void EventCount::notify_all() {
  notify(INT_MAX);
}

void EventCount::notify(int count) {
  if (count <= 0 || sleepers_.load() == 0) return;
  epoch_.fetch_add(1);
  syscall(SYS_futex, &epoch_, FUTEX_WAKE_PRIVATE, count, nullptr, nullptr, 0);
}

}  // namespace pavo
