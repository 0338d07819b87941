// Looking for something a little longer before sleeping for it, where that pays.
#pragma once

#include <algorithm>
#include <cstdint>
#include <thread>

namespace pavo {

inline void pause_briefly() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

/// A sleep costs the sleeper tens of microseconds, and the one who wakes it some: where what is slept for usually comes
/// sooner than that, looking on is the cheaper way. It learns from its own sleeps which is the case: short ones double
/// the looks before the next (up to some 20 us), long ones halve them (down to well under a microsecond). So with
/// stages of milliseconds nobody spins, and with empty ones nobody sleeps. One thread's own.
class ShortWait {
 public:
  /// Whether there() became true while it was looked for.
  template <class There>
  bool look(const There& there) const {
    for (int look = 1; look <= looks_; ++look) {
      if (there()) return true;
      pause_briefly();
      // Whoever makes it come true may be waiting for this very core.
      if (look % kLooksAYield == 0) std::this_thread::yield();
    }
    return false;
  }
  void slept(std::int64_t ns) { looks_ = ns < kShort_ns ? std::min(2 * looks_, kMost) : std::max(looks_ / 2, kLeast); }

 private:
  static constexpr int kLeast = 8, kMost = 256, kLooksAYield = 32;
  static constexpr std::int64_t kShort_ns = 100'000;  // with the time that waking up takes

  int looks_ = kLeast;
};

}  // namespace pavo
