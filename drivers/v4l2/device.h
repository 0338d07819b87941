// A camera's node: opened, asked what it is, what pictures it has and how large and how often.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "drivers/v4l2/pixel_format.h"
#include "drivers/v4l2/system_calls.h"

namespace pavo::v4l2 {

/// What a camera or its driver refused. The message is one line: the node, what failed, what to do; `code` is the
/// system's errno, 0 where none is behind it.
class DeviceError : public std::runtime_error {
 public:
  explicit DeviceError(const std::string& message, int code = 0) : std::runtime_error(message), code_(code) {}
  int code() const { return code_; }

 private:
  int code_;
};

struct DeviceName {
  std::string card;    ///< "Integrated Camera"
  std::string driver;  ///< "uvcvideo"
  std::string bus;     ///< "usb-0000:00:14.0-1"
};

struct FrameSize {
  int width = 0;
  int height = 0;
  bool operator==(const FrameSize&) const = default;
};

/// Sizes from `smallest` to `largest` in steps; where all three are one size, that one only.
struct SizeRange {
  FrameSize smallest, largest, step;
  bool has(const FrameSize& size) const;
  bool is_one() const { return smallest == largest; }
};

struct RateRange {
  double slowest_hz = 0, fastest_hz = 0;
};

struct OfferedFormat {
  std::uint32_t fourcc = 0;
  std::string description;  ///< the driver's
  std::vector<SizeRange> sizes;
};

/// An open node that gives pictures by streaming. The functions ask the driver, and may block it for milliseconds
/// (uvcvideo asks the camera over its cable). One thread at a time.
class Device {
 public:
  /// Throws DeviceError for a node that is not there, may not be opened, is no V4L2 device, or gives no pictures:
  /// a webcam has a second node beside its camera's, for metadata.
  Device(SystemCalls& system, const std::string& path);

  const std::string& path() const { return path_; }
  const DeviceName& name() const { return name_; }
  int fd() const { return fd_.get(); }
  SystemCalls& system() const { return *system_; }
  std::uint32_t buffer_type() const { return buffer_type_; }
  bool multi_planar() const;

  /// 0 or more, or -errno; signals do not disturb it.
  int ioctl(unsigned long request, void* argument) const { return ioctl_again(*system_, fd(), request, argument); }

  /// All formats, those that pavo cannot read, too.
  std::vector<OfferedFormat> formats() const;
  /// Slowest and fastest; nothing where the driver does not tell.
  std::optional<RateRange> rates(std::uint32_t fourcc, const FrameSize& size) const;
  /// The rates one by one, where the driver lists them; else empty.
  std::vector<double> listed_rates_hz(std::uint32_t fourcc, const FrameSize& size) const;

 private:
  std::vector<SizeRange> sizes(std::uint32_t fourcc) const;

  SystemCalls* system_;
  std::string path_;
  Descriptor fd_;
  DeviceName name_;
  std::uint32_t buffer_type_ = 0;
};

}  // namespace pavo::v4l2
