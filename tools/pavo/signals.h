// SIGINT and SIGTERM: the first drains, the second ends at once.
#pragma once

#include <functional>
#include <thread>

namespace pavo {

/// While it lives, the two signals are taken by a thread of its own, through a signalfd: `drain` is called (by that
/// thread) at the first one; at the second the process ends with status 130. Make it before any other thread, so that
/// all inherit the blocked signals; one at a time. Throws std::runtime_error where the system refuses.
class Signals {
 public:
  explicit Signals(std::function<void()> drain);
  ~Signals();
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;

 private:
  void listen();

  std::function<void()> drain_;
  int signals_ = -1;  ///< signalfd
  int ended_ = -1;    ///< eventfd: the destructor's word to the thread
  std::jthread listener_;
};

}  // namespace pavo
