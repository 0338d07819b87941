#include "drivers/v4l2/stamps.h"

#include <algorithm>

namespace pavo::v4l2 {

bool FrameClock::believed(const DriverStamp& stamp, std::int64_t now_ns) {
  // The first exposure may have begun before the call that started the camera was through.
  constexpr std::int64_t kSlack_ns = 1'000'000'000;
  if (!stamp.is_monotonic)
    ++counts_.other_clock;
  else if (stamp.t_ns > now_ns)
    ++counts_.future;
  else if (stamp.t_ns < started_ns_ - kSlack_ns)
    ++counts_.before_start;
  else if (last_ns_ && stamp.t_ns <= *last_ns_)
    ++counts_.backwards;
  else
    return true;
  return false;
}

std::int64_t FrameClock::time_of(const DriverStamp& stamp, std::int64_t now_ns) {
  std::int64_t t = believed(stamp, now_ns) ? stamp.t_ns : now_ns;
  // Two frames that are taken out in one go, both with replaced times.
  if (last_ns_) t = std::max(t, *last_ns_ + 1);
  last_ns_ = t;
  return t;
}

std::uint64_t SequenceCheck::lost_before(std::uint32_t sequence) {
  const std::uint32_t step = last_ ? sequence - *last_ : 1;  // modulo 2^32, as the count is
  last_ = sequence;
  constexpr std::uint32_t kBackwards = 1u << 31;
  return step == 0 || step >= kBackwards ? 0 : step - 1;
}

}  // namespace pavo::v4l2
