#include "drivers/v4l2/device.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace pavo::v4l2 {
namespace {

constexpr std::uint32_t kMost = 256;  // of formats, sizes or rates: a driver that never says "no more" is cut off

// A driver's text may fill its field without a 0 at the end, and hold anything.
template <std::size_t N>
std::string text_of(const std::uint8_t (&field)[N]) {
  std::string text;
  for (std::size_t i = 0; i < N && field[i] != 0; ++i)
    text += field[i] >= ' ' && field[i] <= '~' ? static_cast<char>(field[i]) : '?';
  return text;
}

double hz_of(const v4l2_fract& interval) {
  return interval.numerator == 0 ? 0 : static_cast<double>(interval.denominator) / interval.numerator;
}

[[noreturn]] void cannot_open(const std::string& path, int error) {
  const std::string what = path + ": ";
  switch (error) {
    case ENOENT:
      throw DeviceError(what + "there is no such device; is the camera plugged in? `pavo devices` lists the cameras",
                        error);
    case EACCES:
    case EPERM:
      throw DeviceError(what + "no permission to open it; add yourself to its group (often `video`) and log in again",
                        error);
    case EISDIR:
      throw DeviceError(what + "is a folder; expected a camera's node such as /dev/video0", error);
    case EBUSY:
      throw DeviceError(what + "is in use by another program; close that one first", error);
    default:
      throw DeviceError(what + "cannot be opened: " + reason(error), error);
  }
}

// The node's own capabilities: `capabilities` are those of all nodes of the driver together.
std::uint32_t capabilities_of(const v4l2_capability& c) {
  return c.capabilities & V4L2_CAP_DEVICE_CAPS ? c.device_caps : c.capabilities;
}

std::string what_it_gives(std::uint32_t capabilities) {
  if (capabilities & V4L2_CAP_META_CAPTURE) return "metadata";
  if (capabilities & (V4L2_CAP_VIDEO_M2M | V4L2_CAP_VIDEO_M2M_MPLANE)) return "conversions of pictures";
  if (capabilities & (V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_VIDEO_OUTPUT_MPLANE)) return "output";
  if (capabilities & (V4L2_CAP_VBI_CAPTURE | V4L2_CAP_SLICED_VBI_CAPTURE)) return "teletext";
  if (capabilities & (V4L2_CAP_RADIO | V4L2_CAP_SDR_CAPTURE | V4L2_CAP_TUNER)) return "radio";
  return "something else";
}

}  // namespace

bool SizeRange::has(const FrameSize& size) const {
  const auto fits = [](int value, int from, int to, int by) {
    return value >= from && value <= to && (by <= 1 || (value - from) % by == 0);
  };
  return fits(size.width, smallest.width, largest.width, step.width) &&
         fits(size.height, smallest.height, largest.height, step.height);
}

Device::Device(SystemCalls& system, const std::string& path) : system_(&system), path_(path) {
  const int fd = system.open(path);
  if (fd < 0) cannot_open(path, -fd);
  fd_ = Descriptor(system, fd);
  v4l2_capability c{};
  if (const int result = ioctl(VIDIOC_QUERYCAP, &c); result < 0) {
    if (result == -ENOTTY || result == -EINVAL)
      throw DeviceError(path + ": is no camera (no V4L2 device); `pavo devices` lists the cameras", -result);
    throw DeviceError(path + ": does not say what it is: " + reason(result), -result);
  }
  name_ = {text_of(c.card), text_of(c.driver), text_of(c.bus_info)};
  const std::uint32_t capabilities = capabilities_of(c);
  if (capabilities & V4L2_CAP_VIDEO_CAPTURE)
    buffer_type_ = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  else if (capabilities & V4L2_CAP_VIDEO_CAPTURE_MPLANE)
    buffer_type_ = V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
  else
    throw DeviceError(path + ": is no camera: this node of '" + name_.card + "' is for " + what_it_gives(capabilities) +
                          "; `pavo devices` lists the cameras",
                      ENODEV);
  if (!(capabilities & V4L2_CAP_STREAMING))
    throw DeviceError(path + ": its driver (" + name_.driver + ") cannot stream; pavo needs streaming buffers", ENOTTY);
}

bool Device::multi_planar() const {
  return buffer_type_ == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
}

std::vector<OfferedFormat> Device::formats() const {
  std::vector<OfferedFormat> formats;
  for (std::uint32_t i = 0; i < kMost; ++i) {
    v4l2_fmtdesc d{};
    d.index = i;
    d.type = buffer_type_;
    if (ioctl(VIDIOC_ENUM_FMT, &d) < 0) break;
    formats.push_back({d.pixelformat, text_of(d.description), sizes(d.pixelformat)});
  }
  return formats;
}

std::vector<SizeRange> Device::sizes(std::uint32_t fourcc) const {
  std::vector<SizeRange> sizes;
  const auto size = [](std::uint32_t w, std::uint32_t h) {
    return FrameSize{static_cast<int>(w), static_cast<int>(h)};
  };
  for (std::uint32_t i = 0; i < kMost; ++i) {
    v4l2_frmsizeenum e{};
    e.index = i;
    e.pixel_format = fourcc;
    if (ioctl(VIDIOC_ENUM_FRAMESIZES, &e) < 0) break;
    if (e.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      const FrameSize one = size(e.discrete.width, e.discrete.height);
      sizes.push_back({one, one, {1, 1}});
      continue;
    }
    const auto& s = e.stepwise;
    sizes.push_back(
        {size(s.min_width, s.min_height), size(s.max_width, s.max_height), size(s.step_width, s.step_height)});
    break;  // a range is the only answer there is
  }
  return sizes;
}

std::vector<double> Device::listed_rates_hz(std::uint32_t fourcc, const FrameSize& size) const {
  std::vector<double> rates;
  for (std::uint32_t i = 0; i < kMost; ++i) {
    v4l2_frmivalenum e{};
    e.index = i;
    e.pixel_format = fourcc;
    e.width = static_cast<std::uint32_t>(size.width);
    e.height = static_cast<std::uint32_t>(size.height);
    if (ioctl(VIDIOC_ENUM_FRAMEINTERVALS, &e) < 0 || e.type != V4L2_FRMIVAL_TYPE_DISCRETE) break;
    rates.push_back(hz_of(e.discrete));
  }
  return rates;
}

std::optional<RateRange> Device::rates(std::uint32_t fourcc, const FrameSize& size) const {
  if (const std::vector<double> listed = listed_rates_hz(fourcc, size); !listed.empty()) {
    const auto [slowest, fastest] = std::minmax_element(listed.begin(), listed.end());
    return RateRange{*slowest, *fastest};
  }
  v4l2_frmivalenum e{};
  e.pixel_format = fourcc;
  e.width = static_cast<std::uint32_t>(size.width);
  e.height = static_cast<std::uint32_t>(size.height);
  if (ioctl(VIDIOC_ENUM_FRAMEINTERVALS, &e) < 0) return std::nullopt;
  return RateRange{hz_of(e.stepwise.max), hz_of(e.stepwise.min)};
}

}  // namespace pavo::v4l2
