#include <array>
#include <condition_variable>
#include <mutex>

#include "bench/handoff/competitors.h"

namespace pavo::bench {
namespace {

// A ring under a lock. There are never more tokens than places.
class Plain final : public Handoff {
 public:
  void put(int token) override {
    {
      const std::lock_guard lock(mutex_);
      ring_[in_++ % kTokens] = token;
    }
    there_.notify_one();
  }
  int take() override {
    std::unique_lock lock(mutex_);
    there_.wait(lock, [&] { return in_ != out_; });
    return ring_[out_++ % kTokens];
  }

 private:
  std::mutex mutex_;
  std::condition_variable there_;
  std::array<int, kTokens> ring_{};
  unsigned in_ = 0, out_ = 0;
};

}  // namespace

std::unique_ptr<Handoff> mutex_and_condition() {
  return std::make_unique<Plain>();
}

}  // namespace pavo::bench
