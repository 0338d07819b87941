#include <concurrentqueue/blockingconcurrentqueue.h>

#include "bench/handoff/competitors.h"

namespace pavo::bench {
namespace {

// With tokens for its two threads, as its README advises.
class Theirs final : public Handoff {
 public:
  void put(int token) override { queue_.enqueue(producer_, token); }
  int take() override {
    int token = 0;
    queue_.wait_dequeue(consumer_, token);
    return token;
  }

 private:
  moodycamel::BlockingConcurrentQueue<int> queue_{4 * kTokens};
  moodycamel::ProducerToken producer_{queue_};
  moodycamel::ConsumerToken consumer_{queue_};
};

}  // namespace

std::unique_ptr<Handoff> moodycamel_concurrent() {
  return std::make_unique<Theirs>();
}

}  // namespace pavo::bench
