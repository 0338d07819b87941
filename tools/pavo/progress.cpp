#include "tools/pavo/progress.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

namespace pavo {

Progress::Progress(std::string what, std::optional<std::int64_t> total, std::function<std::int64_t()> done)
    : what_(std::move(what)), total_(total), done_(std::move(done)) {
  start();
}

Progress::Progress(std::string what, std::function<std::string()> status)
    : what_(std::move(what)), status_(std::move(status)) {
  start();
}

void Progress::start() {
  if (isatty(STDERR_FILENO)) thread_ = std::jthread([this](const std::stop_token& stop) { draw_until(stop); });
}

Progress::~Progress() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
  std::fprintf(stderr, "\r\033[K");
}

void Progress::draw_until(const std::stop_token& stop) {
  constexpr int kWidth = 30;
  const auto start = std::chrono::steady_clock::now();
  const std::chrono::milliseconds period(status_ ? 1000 : 200);
  std::unique_lock lock(mutex_);
  while (!ended_.wait_for(lock, stop, period, [] { return false; }) && !stop.stop_requested()) {
    if (status_) {
      std::fprintf(stderr, "\r\033[K%s: %s", what_.c_str(), status_().c_str());
      std::fflush(stderr);
      continue;
    }
    const std::int64_t done = done_();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    std::fprintf(stderr, "\r\033[K%s ", what_.c_str());
    if (total_ && *total_ > 0) {
      const int filled = static_cast<int>(std::min(done, *total_) * kWidth / *total_);
      std::fprintf(stderr, "[%s%s] %ld/%ld", std::string(filled, '#').c_str(),
                   std::string(kWidth - filled, '.').c_str(), static_cast<long>(done), static_cast<long>(*total_));
    } else {
      std::fprintf(stderr, "%ld frames", static_cast<long>(done));
    }
    std::fprintf(stderr, ", %.0f a second", static_cast<double>(done) / seconds);
    std::fflush(stderr);
  }
}

}  // namespace pavo
