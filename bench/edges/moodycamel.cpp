#include <concurrentqueue/concurrentqueue.h>

#include <deque>

#include "bench/edges/competitors.h"

namespace pavo::bench {
namespace {

using Queue = moodycamel::ConcurrentQueue<std::uint32_t>;

// Explicit producers with several blocks each, and only try_enqueue, so that nothing is allocated.
class Theirs final : public Edge {
 public:
  explicit Theirs(int threads) : queue_(kBlocks * Queue::BLOCK_SIZE * static_cast<std::size_t>(threads), threads, 0) {
    for (int t = 0; t < threads; ++t) {
      producers_.emplace_back(queue_);
      consumers_.emplace_back(queue_);
    }
  }
  bool put(int producer, int token) override {
    return queue_.try_enqueue(producers_[producer], static_cast<std::uint32_t>(token));
  }
  std::optional<int> take(int consumer, int) override {
    std::uint32_t token = 0;
    if (!queue_.try_dequeue(consumers_[consumer], token)) return std::nullopt;
    return static_cast<int>(token);
  }

 private:
  static constexpr std::size_t kBlocks = 4;
  Queue queue_;
  std::deque<moodycamel::ProducerToken> producers_;
  std::deque<moodycamel::ConsumerToken> consumers_;
};

}  // namespace

std::unique_ptr<Edge> moodycamel_queue(int threads) {
  return std::make_unique<Theirs>(threads);
}

}  // namespace pavo::bench
