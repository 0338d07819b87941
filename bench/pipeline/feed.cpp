#include "bench/pipeline/feed.h"

#include <algorithm>
#include <cmath>
#include <ctime>

#include "engine/clock.h"

namespace pavo::bench {

Feed::Feed(std::int64_t frames, double rate_hz, std::int64_t warm_up)
    : frames_(frames),
      warm_up_(warm_up),
      rate_hz_(rate_hz),
      arrival_(static_cast<std::size_t>(frames)),
      done_(static_cast<std::size_t>(frames)) {}

std::int64_t Feed::next() {
  if (next_ == frames_) return -1;
  const SteadyClock clock;
  if (start_ns_ == 0) start_ns_ = clock.now_ns();
  const std::int64_t k = next_++;
  std::int64_t& arrival = arrival_[static_cast<std::size_t>(k)];
  if (rate_hz_ <= 0) {
    arrival = clock.now_ns();
    return k;
  }
  arrival = start_ns_ + std::llround(static_cast<double>(k) / rate_hz_ * 1e9);
  const timespec until{.tv_sec = arrival / 1'000'000'000, .tv_nsec = arrival % 1'000'000'000};
  while (clock.now_ns() < arrival) clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
  return k;
}

void Feed::done(std::int64_t k) {
  done_[static_cast<std::size_t>(k)] = SteadyClock().now_ns();
}

std::int64_t Feed::arrival_ns(std::int64_t k) const {
  return arrival_[static_cast<std::size_t>(k)];
}

double Feed::frames_per_second() const {
  const auto from = static_cast<std::size_t>(warm_up_);
  return static_cast<double>(frames_ - warm_up_ - 1) * 1e9 / static_cast<double>(done_.back() - done_[from]);
}

std::vector<double> Feed::latencies_ms() const {
  std::vector<double> all;
  for (auto k = static_cast<std::size_t>(warm_up_); k < done_.size(); ++k)
    all.push_back(static_cast<double>(done_[k] - arrival_[k]) * 1e-6);
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace pavo::bench
