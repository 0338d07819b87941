#include <oneapi/tbb/concurrent_queue.h>

#include "bench/handoff/competitors.h"

namespace pavo::bench {
namespace {

class Theirs final : public Handoff {
 public:
  Theirs() { queue_.set_capacity(kTokens); }
  void put(int token) override { queue_.push(token); }
  int take() override {
    int token = 0;
    queue_.pop(token);
    return token;
  }

 private:
  tbb::concurrent_bounded_queue<int> queue_;
};

}  // namespace

std::unique_ptr<Handoff> tbb_bounded_queue() {
  return std::make_unique<Theirs>();
}

}  // namespace pavo::bench
