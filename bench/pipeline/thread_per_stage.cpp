// A thread for each stage, and between two a bounded queue: a ring under a mutex with condition variables.
#include <array>
#include <condition_variable>
#include <mutex>
#include <semaphore>
#include <thread>
#include <vector>

#include "bench/pipeline/competitors.h"

namespace pavo::bench {
namespace {

class BoundedQueue {
 public:
  explicit BoundedQueue(int capacity) : ring_(static_cast<std::size_t>(capacity)) {}

  void push(std::int64_t k) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return in_ - out_ < ring_.size(); });
    ring_[in_++ % ring_.size()] = k;
    lock.unlock();
    changed_.notify_one();
  }
  std::int64_t pop() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return in_ != out_; });
    const std::int64_t k = ring_[out_++ % ring_.size()];
    lock.unlock();
    changed_.notify_one();
    return k;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;  // one side waits at a time: empty and full exclude each other
  std::vector<std::int64_t> ring_;
  std::size_t in_ = 0, out_ = 0;
};

}  // namespace

void run_thread_per_stage(Work& work, Feed& feed, const Setup& setup) {
  work.begin(setup.tokens, nullptr);
  std::counting_semaphore<64> tokens(setup.tokens);
  std::vector<std::unique_ptr<BoundedQueue>> queues;
  for (int s = 0; s < Work::kStages; ++s) queues.push_back(std::make_unique<BoundedQueue>(setup.tokens));
  std::vector<std::jthread> threads;
  for (int s = 0; s < Work::kStages; ++s)
    threads.emplace_back([&, s] {
      for (std::int64_t k = 0; k >= 0;) {
        k = queues[static_cast<std::size_t>(s)]->pop();
        if (k >= 0) work.stage(s, k);
        if (s + 1 < Work::kStages) {
          queues[static_cast<std::size_t>(s) + 1]->push(k);
        } else if (k >= 0) {
          feed.done(k);
          tokens.release();
        }
      }
    });
  for (std::int64_t k = 0; k >= 0;) {
    tokens.acquire();
    k = feed.next();
    if (k >= 0) work.load(k);
    queues[0]->push(k);
  }
}

}  // namespace pavo::bench
