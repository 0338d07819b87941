// What a background stage has taken over and not yet worked on.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "engine/frame_info.h"

namespace pavo {

/// A ring of as many jobs as the stage has Work memories. room() and put() are the workers', one at a time, since the
/// stage takes frames in order; front() and pop() the background thread's. Never waits, never allocates.
class BackgroundJobs {
 public:
  struct Job {
    FrameInfo info;
    std::int64_t t_ready_ns = 0;
    int work = 0;  ///< index of the Work memory
  };

  explicit BackgroundJobs(int capacity) : jobs_(static_cast<std::size_t>(capacity)) {}

  /// The Work memory that is free for the next job, or -1.
  int room() const {
    const std::uint64_t put = put_.load();
    return put - popped_.load() < jobs_.size() ? static_cast<int>(put % jobs_.size()) : -1;
  }
  void put(const FrameInfo& info, std::int64_t now_ns) {
    const std::uint64_t put = put_.load();
    const std::size_t at = put % jobs_.size();
    jobs_[at] = {info, now_ns, static_cast<int>(at)};
    put_.store(put + 1);
  }

  const Job* front() const {
    const std::uint64_t popped = popped_.load();
    return popped == put_.load() ? nullptr : &jobs_[popped % jobs_.size()];
  }
  void pop() { popped_.fetch_add(1); }

 private:
  std::vector<Job> jobs_;
  std::atomic<std::uint64_t> put_{0};
  alignas(64) std::atomic<std::uint64_t> popped_{0};
};

}  // namespace pavo
