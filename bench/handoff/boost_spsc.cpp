// It has no way to sleep: who finds it empty yields the core and asks again.
#include <boost/lockfree/spsc_queue.hpp>
#include <thread>

#include "bench/handoff/competitors.h"

namespace pavo::bench {
namespace {

class Theirs final : public Handoff {
 public:
  void put(int token) override {
    while (!queue_.push(token)) std::this_thread::yield();
  }
  int take() override {
    int token = 0;
    while (!queue_.pop(token)) std::this_thread::yield();
    return token;
  }

 private:
  boost::lockfree::spsc_queue<int, boost::lockfree::capacity<kTokens>> queue_;
};

}  // namespace

std::unique_ptr<Handoff> boost_spsc() {
  return std::make_unique<Theirs>();
}

}  // namespace pavo::bench
