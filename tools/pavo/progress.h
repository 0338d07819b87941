// A progress bar on a terminal; nothing at all in a pipe.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace pavo {

/// Draws on stderr, five times a second, by a thread of its own, what `done` returns (which it calls), out of `total`
/// where that is known; or, once a second, the line that `status` returns. Vanishes without a trace in the destructor.
class Progress {
 public:
  Progress(std::string what, std::optional<std::int64_t> total, std::function<std::int64_t()> done);
  Progress(std::string what, std::function<std::string()> status);
  ~Progress();

 private:
  void start();
  void draw_until(const std::stop_token& stop);

  std::string what_;
  std::optional<std::int64_t> total_;
  std::function<std::int64_t()> done_;
  std::function<std::string()> status_;
  std::mutex mutex_;
  std::condition_variable_any ended_;
  std::jthread thread_;
};

}  // namespace pavo
