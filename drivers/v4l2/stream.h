// The buffers that a driver fills: asked for, mapped, queued, and running until the end of their life.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/v4l2/device.h"
#include "drivers/v4l2/stamps.h"

namespace pavo::v4l2 {

/// One filled buffer. Its bytes are the driver's memory, and valid until it is queued again or the stream ends.
struct FilledBuffer {
  std::uint32_t index = 0;
  std::uint32_t sequence = 0;  ///< the driver's count
  bool damaged = false;        ///< V4L2_BUF_FLAG_ERROR
  DriverStamp stamp;
  std::span<const std::uint8_t> bytes;  ///< of the first plane, as many as are used
};

/// One thread at a time. Nothing here blocks; waiting is poll()'s, on the device's descriptor.
class Stream {
 public:
  /// Throws DeviceError (ENOSPC: the USB bus has no bandwidth left for this format). `buffers`: the driver may give
  /// more or fewer; with fewer than two nothing can stream.
  Stream(const Device& device, int buffers);
  /// Stops, unmaps, and gives the driver its memory back.
  ~Stream();
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  int buffers() const { return static_cast<int>(mappings_.size()); }
  /// The oldest filled one. 0, or -EAGAIN where there is none, or what is wrong with the device.
  int dequeue(FilledBuffer& filled);
  /// Gives a buffer back. A driver that refuses it once is asked again by the next dequeue(); twice is an error there.
  void queue(std::uint32_t index);

 private:
  int try_queue(std::uint32_t index) const;
  int queue_owed();
  void map(std::uint32_t index);

  const Device& device_;
  std::vector<Mapping> mappings_;
  std::vector<std::uint32_t> owed_;  ///< buffers that the driver did not take back
};

}  // namespace pavo::v4l2
