// A V4L2 driver that the test plays: buffers, formats, stamps and errors as the script says, on a clock of its own. It
// is as strict as the kernel is: no buffer is queued twice, no format is set while buffers are there, nothing is used
// after it was closed or unmapped.
#pragma once

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "drivers/v4l2/system_calls.h"

namespace pavo::v4l2::test {

/// What the driver shows next.
struct Shown {
  std::uint32_t sequence = 0;
  std::int64_t stamp_ns = 0;
  std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  std::uint32_t bytes_used = UINT32_MAX;  ///< as many as the format has
  std::uint8_t gray = 0;                  ///< of all its bytes
  std::span<const std::uint8_t> picture;  ///< over that: its first bytes
};

class PlayedDriver final : public SystemCalls {
 public:
  // --- the script; set before the camera is opened, or through with_lock()
  std::string card = "Played";
  std::uint32_t device_caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  struct Offer {
    std::uint32_t fourcc;
    std::vector<std::pair<int, int>> sizes;
    double fastest_hz = 30;
  };
  std::vector<Offer> offers{{V4L2_PIX_FMT_GREY, {{64, 32}, {32, 16}}, 30}};
  std::uint32_t most_buffers = 32;
  std::uint32_t padding = 0;                      ///< bytes behind each row
  std::function<void(v4l2_pix_format&)> changes;  ///< what the driver makes of a format
  bool present = true;
  /// The next results of a request: errors (negative) that it fails with, one a call.
  std::map<unsigned long, std::deque<int>> fails;
  int open_fails = 0;  ///< -errno of every open

  PlayedDriver() = default;
  ~PlayedDriver() override {
    EXPECT_EQ(descriptors_.size(), 0u) << "left open";
    EXPECT_EQ(maps_.size(), 0u) << "left mapped";
  }

  template <class F>
  auto with_lock(F&& f) {
    const std::lock_guard lock(mutex_);
    return f();
  }
  void fail(unsigned long request, int error, int times = 1) {
    const std::lock_guard lock(mutex_);
    for (int n = 0; n < times; ++n) fails[request].push_back(error);
  }
  /// A frame is shown; where no buffer is queued for it, it is lost, as in life.
  bool show(const Shown& shown);
  /// The node goes, or comes back.
  void unplug();
  void plug_in();
  /// Moves the clock; who polls with a deadline that this passes, wakes.
  void advance(std::int64_t ns);
  int queued_buffers() {
    const std::lock_guard lock(mutex_);
    return static_cast<int>(queued_.size());
  }
  int buffers() {
    const std::lock_guard lock(mutex_);
    return static_cast<int>(memory_.size());
  }
  bool streams() {
    const std::lock_guard lock(mutex_);
    return streaming_;
  }
  int opened() {
    const std::lock_guard lock(mutex_);
    return opened_;
  }
  /// Opens that found no node.
  int found_none() {
    const std::lock_guard lock(mutex_);
    return found_none_;
  }

  // --- SystemCalls
  int open(const std::string& path) override;
  void close(int fd) override;
  int ioctl(int fd, unsigned long request, void* argument) override;
  void* map(int fd, std::size_t bytes, std::int64_t offset) override;
  void unmap(void* start, std::size_t bytes) override;
  int poll(std::span<pollfd> descriptors, std::int64_t timeout_ns) override;
  int watch(const std::string& directory) override;
  void forget_events(int fd) override;
  std::int64_t now_ns() override;

 private:
  enum class Kind { camera, watch };
  int answer(unsigned long request, void* argument);
  int enumerate(unsigned long request, void* argument) const;
  int set_format(v4l2_format& format);
  int request_buffers(v4l2_requestbuffers& request);
  int queue(const v4l2_buffer& buffer);
  int dequeue(v4l2_buffer& buffer);
  void stop();
  const Offer* offer(std::uint32_t fourcc) const;

  std::mutex mutex_;
  std::int64_t now_ns_ = 1'000'000'000'000;
  int next_fd_ = 100000;  // none that the process has
  std::map<int, Kind> descriptors_;
  std::map<void*, std::size_t> maps_;
  std::vector<std::vector<std::uint8_t>> memory_;
  std::deque<std::uint32_t> queued_;
  std::deque<std::pair<std::uint32_t, Shown>> filled_;
  v4l2_pix_format format_{};
  double rate_hz_ = 5;
  bool streaming_ = false, gone_ = false, events_ = false;
  int opened_ = 0, found_none_ = 0;
};

}  // namespace pavo::v4l2::test
