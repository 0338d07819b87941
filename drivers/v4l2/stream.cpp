#include "drivers/v4l2/stream.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <cerrno>

namespace pavo::v4l2 {
namespace {

// A v4l2_buffer with room for the planes that a multi-planar one needs.
struct Buffer {
  explicit Buffer(const Device& device) {
    plain.type = device.buffer_type();
    plain.memory = V4L2_MEMORY_MMAP;
    if (device.multi_planar()) {
      plain.m.planes = planes.data();
      plain.length = static_cast<std::uint32_t>(planes.size());
    }
  }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  v4l2_buffer plain{};
  std::array<v4l2_plane, VIDEO_MAX_PLANES> planes{};
};

int request_buffers(const Device& device, int count) {
  v4l2_requestbuffers request{};
  request.count = static_cast<std::uint32_t>(count);
  request.type = device.buffer_type();
  request.memory = V4L2_MEMORY_MMAP;
  const int result = device.ioctl(VIDIOC_REQBUFS, &request);
  return result < 0 ? result : static_cast<int>(request.count);
}

DriverStamp stamp_of(const v4l2_buffer& buffer) {
  DriverStamp stamp{.t_ns = std::int64_t{buffer.timestamp.tv_sec} * 1'000'000'000 +
                            std::int64_t{buffer.timestamp.tv_usec} * 1000};
  stamp.is_monotonic = (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  stamp.at_start = (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  return stamp;
}

[[noreturn]] void cannot_start(const Device& device, int error) {
  const std::string what = device.path() + ": cannot start streaming: ";
  switch (error) {
    case ENOSPC:
      throw DeviceError(what +
                            "the USB bus has no bandwidth left; choose a smaller picture, a lower --rate or the "
                            "format MJPG, or plug other cameras elsewhere",
                        error);
    case EBUSY:
      throw DeviceError(what + "it is in use by another program; close that one first", error);
    default:
      throw DeviceError(what + reason(error), error);
  }
}

}  // namespace

Stream::Stream(const Device& device, int buffers) : device_(device) {
  const int given = request_buffers(device, buffers);
  if (given == -EBUSY) throw DeviceError(device.path() + ": is in use by another program; close that one first", EBUSY);
  if (given < 0) throw DeviceError(device.path() + ": gives no buffers: " + reason(given), -given);
  constexpr int kFewest = 2;  // one to fill, one to read
  if (given < kFewest) {
    request_buffers(device, 0);
    throw DeviceError(device.path() + ": gives " + std::to_string(given) + " of " + std::to_string(buffers) +
                          " buffers; expected 2 or more",
                      ENOMEM);
  }
  const auto give_back = [&] {
    mappings_.clear();
    request_buffers(device_, 0);
  };
  try {
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(given); ++i) map(i);
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(given); ++i)
      if (const int result = try_queue(i); result < 0) cannot_start(device, -result);
    auto type = static_cast<int>(device.buffer_type());
    if (const int result = device.ioctl(VIDIOC_STREAMON, &type); result < 0) cannot_start(device, -result);
  } catch (...) {
    give_back();
    throw;
  }
}

// In this order: a driver does not take back what is still mapped, and with buffers left it refuses the next format.
Stream::~Stream() {
  auto type = static_cast<int>(device_.buffer_type());
  device_.ioctl(VIDIOC_STREAMOFF, &type);
  mappings_.clear();
  request_buffers(device_, 0);
}

void Stream::map(std::uint32_t index) {
  Buffer buffer(device_);
  buffer.plain.index = index;
  if (const int result = device_.ioctl(VIDIOC_QUERYBUF, &buffer.plain); result < 0) cannot_start(device_, -result);
  const bool planar = device_.multi_planar();
  const std::size_t bytes = planar ? buffer.planes[0].length : buffer.plain.length;
  const std::int64_t offset = planar ? buffer.planes[0].m.mem_offset : buffer.plain.m.offset;
  void* start = device_.system().map(device_.fd(), bytes, offset);
  if (!start) throw DeviceError(device_.path() + ": its buffers cannot be mapped; expected a driver with MMAP", ENOMEM);
  mappings_.emplace_back(device_.system(), start, bytes);
}

int Stream::try_queue(std::uint32_t index) const {
  Buffer buffer(device_);
  buffer.plain.index = index;
  return device_.ioctl(VIDIOC_QBUF, &buffer.plain);
}

void Stream::queue(std::uint32_t index) {
  if (try_queue(index) < 0) owed_.push_back(index);
}

int Stream::queue_owed() {
  while (!owed_.empty()) {
    if (const int result = try_queue(owed_.back()); result < 0) return result;
    owed_.pop_back();
  }
  return 0;
}

int Stream::dequeue(FilledBuffer& filled) {
  if (const int result = queue_owed(); result < 0) return result;
  Buffer buffer(device_);
  if (const int result = device_.ioctl(VIDIOC_DQBUF, &buffer.plain); result < 0) return result;
  if (buffer.plain.index >= mappings_.size()) return -EIO;
  const std::span<const std::uint8_t> all = mappings_[buffer.plain.index].bytes();
  const bool planar = device_.multi_planar();
  const std::size_t begin = std::min<std::size_t>(planar ? buffer.planes[0].data_offset : 0, all.size());
  const std::size_t end =
      std::min<std::size_t>(planar ? buffer.planes[0].bytesused : buffer.plain.bytesused, all.size());
  filled = {.index = buffer.plain.index,
            .sequence = buffer.plain.sequence,
            .damaged = (buffer.plain.flags & V4L2_BUF_FLAG_ERROR) != 0,
            .stamp = stamp_of(buffer.plain),
            .bytes = all.subspan(begin, end > begin ? end - begin : 0)};
  return 0;
}

}  // namespace pavo::v4l2
