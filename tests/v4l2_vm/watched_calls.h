// The kernel's calls, watched: whose fault it is that a frame was lost. A driver that has an empty buffer and yet
// leaves a frame out was late itself; one that has none was starved by us.
#pragma once

#include <linux/videodev2.h>

#include <mutex>
#include <vector>

#include "drivers/v4l2/system_calls.h"

namespace pavo::v4l2::test {

class WatchedCalls final : public SystemCalls {
 public:
  struct Dequeued {
    std::uint32_t sequence;
    std::int64_t stamp_ns;
  };
  struct Losses {
    int all = 0;      ///< holes in the driver's count
    int starved = 0;  ///< of them, while no buffer was with the driver to be filled
  };

  int open(const std::string& path) override { return kernel_.open(path); }
  void close(int fd) override { kernel_.close(fd); }
  void* map(int fd, std::size_t bytes, std::int64_t offset) override { return kernel_.map(fd, bytes, offset); }
  void unmap(void* start, std::size_t bytes) override { kernel_.unmap(start, bytes); }
  int poll(std::span<pollfd> fds, std::int64_t timeout_ns) override { return kernel_.poll(fds, timeout_ns); }
  int watch(const std::string& directory) override { return kernel_.watch(directory); }
  void forget_events(int fd) override { kernel_.forget_events(fd); }
  std::int64_t now_ns() override { return kernel_.now_ns(); }

  int ioctl(int fd, unsigned long request, void* argument) override {
    const int result = kernel_.ioctl(fd, request, argument);
    if (result < 0) return result;
    const std::lock_guard lock(mutex_);
    if (request == VIDIOC_REQBUFS) {
      queued_ns_.clear();
      dequeued_.clear();
    } else if (request == VIDIOC_QBUF) {
      queued_ns_.push_back(kernel_.now_ns());  // with the driver by now, at the latest
    } else if (request == VIDIOC_DQBUF) {
      const auto& buffer = *static_cast<const v4l2_buffer*>(argument);
      dequeued_.push_back({buffer.sequence, std::int64_t{buffer.timestamp.tv_sec} * 1'000'000'000 +
                                                std::int64_t{buffer.timestamp.tv_usec} * 1000});
    }
    return result;
  }

  /// Since the present buffers were asked for.
  std::vector<Dequeued> dequeued() const {
    const std::lock_guard lock(mutex_);
    return dequeued_;
  }
  Losses losses() const {
    const std::lock_guard lock(mutex_);
    Losses losses;
    for (std::size_t n = 1; n < dequeued_.size(); ++n) {
      const Dequeued &last = dequeued_[n - 1], &next = dequeued_[n];
      const auto missing = static_cast<std::int64_t>(next.sequence - last.sequence) - 1;
      for (std::int64_t i = 1; i <= missing; ++i) {
        const std::int64_t t = last.stamp_ns + i * (next.stamp_ns - last.stamp_ns) / (missing + 1);
        ++losses.all;
        losses.starved += queued_until(t) <= n;  // n were filled before
      }
    }
    return losses;
  }

 private:
  std::size_t queued_until(std::int64_t t_ns) const {
    std::size_t count = 0;
    while (count < queued_ns_.size() && queued_ns_[count] <= t_ns) ++count;
    return count;
  }

  Kernel kernel_;
  mutable std::mutex mutex_;
  std::vector<std::int64_t> queued_ns_;  ///< when each buffer was given to the driver
  std::vector<Dequeued> dequeued_;
};

}  // namespace pavo::v4l2::test
