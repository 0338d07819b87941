#include "tools/pavo/signals.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <stdexcept>

namespace pavo {
namespace {

constexpr int kInterrupted = 130;  // 128 + SIGINT, as shells have it

sigset_t the_two() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}

}  // namespace

Signals::Signals(std::function<void()> drain) : drain_(std::move(drain)) {
  const sigset_t set = the_two();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  signals_ = signalfd(-1, &set, SFD_CLOEXEC);
  ended_ = eventfd(0, EFD_CLOEXEC);
  if (signals_ < 0 || ended_ < 0) throw std::runtime_error("the system gives no signalfd: no clean end at Ctrl-C");
  listener_ = std::jthread([this] { listen(); });
}

Signals::~Signals() {
  const std::uint64_t one = 1;
  while (write(ended_, &one, sizeof one) < 0) {  // EINTR; an eventfd at 0 always takes a 1
  }
  listener_.join();
  close(signals_);
  close(ended_);
  const sigset_t set = the_two();
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

void Signals::listen() {
  for (int count = 0;;) {
    pollfd sources[2] = {{signals_, POLLIN, 0}, {ended_, POLLIN, 0}};
    if (poll(sources, 2, -1) < 0) continue;  // EINTR
    if (sources[1].revents) return;
    signalfd_siginfo info{};
    if (read(signals_, &info, sizeof info) != sizeof info) continue;
    if (++count == 2) _exit(kInterrupted);
    drain_();
  }
}

}  // namespace pavo
