#include "drivers/v4l2/negotiate.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>

namespace pavo::v4l2 {
namespace {

std::string size_text(const FrameSize& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

// The two ways in which a driver tells one thing.
struct PlainFormat {
  std::uint32_t fourcc = 0, field = 0, stride = 0;
  FrameSize size;
};

PlainFormat plain(const Device& device, const v4l2_format& f) {
  const auto size = [](std::uint32_t w, std::uint32_t h) {
    return FrameSize{static_cast<int>(w), static_cast<int>(h)};
  };
  if (device.multi_planar())
    return {f.fmt.pix_mp.pixelformat, f.fmt.pix_mp.field, f.fmt.pix_mp.plane_fmt[0].bytesperline,
            size(f.fmt.pix_mp.width, f.fmt.pix_mp.height)};
  return {f.fmt.pix.pixelformat, f.fmt.pix.field, f.fmt.pix.bytesperline, size(f.fmt.pix.width, f.fmt.pix.height)};
}

v4l2_format wanted(const Device& device, std::uint32_t fourcc, const FrameSize& size) {
  v4l2_format f{};
  f.type = device.buffer_type();
  const auto width = static_cast<std::uint32_t>(size.width), height = static_cast<std::uint32_t>(size.height);
  if (device.multi_planar()) {
    f.fmt.pix_mp.width = width;
    f.fmt.pix_mp.height = height;
    f.fmt.pix_mp.pixelformat = fourcc;
    f.fmt.pix_mp.field = V4L2_FIELD_NONE;
  } else {
    f.fmt.pix.width = width;
    f.fmt.pix.height = height;
    f.fmt.pix.pixelformat = fourcc;
    f.fmt.pix.field = V4L2_FIELD_NONE;
  }
  return f;
}

FrameSize size_of_now(const Device& device) {
  v4l2_format f{};
  f.type = device.buffer_type();
  const int result = device.ioctl(VIDIOC_G_FMT, &f);
  if (result < 0) throw DeviceError(device.path() + ": does not tell its format: " + reason(result), -result);
  return plain(device, f).size;
}

std::string offer_text(const std::vector<OfferedFormat>& offered) {
  std::string text;
  for (const OfferedFormat& format : offered) {
    text += (text.empty() ? "" : "; ") + fourcc_text(format.fourcc);
    for (const SizeRange& range : format.sizes)
      text += " " + size_text(range.smallest) + (range.is_one() ? "" : " to " + size_text(range.largest));
  }
  return text.empty() ? "nothing" : text;
}

bool has_size(const OfferedFormat& format, const FrameSize& size) {
  return format.sizes.empty() ||  // a driver that does not list them may have it all the same
         std::any_of(format.sizes.begin(), format.sizes.end(), [&](const SizeRange& r) { return r.has(size); });
}

// Not every driver takes a rate, and none has to take this one.
double set_rate(const Device& device, double rate_hz) {
  v4l2_streamparm parm{};
  parm.type = device.buffer_type();
  if (device.ioctl(VIDIOC_G_PARM, &parm) < 0) return 0;
  if (rate_hz > 0 && parm.parm.capture.capability & V4L2_CAP_TIMEPERFRAME) {
    v4l2_streamparm set = parm;
    set.parm.capture.timeperframe = {1000, static_cast<std::uint32_t>(std::lround(rate_hz * 1000))};
    if (device.ioctl(VIDIOC_S_PARM, &set) >= 0) parm = set;
  }
  const v4l2_fract& interval = parm.parm.capture.timeperframe;
  return interval.numerator == 0 ? 0 : static_cast<double>(interval.denominator) / interval.numerator;
}

void check(const Device& device, const PixelFormat& pixels, const FrameSize& size, const PlainFormat& got) {
  const std::string asked = std::string(pixels.name) + " " + size_text(size);
  if (got.fourcc != pixels.fourcc || got.size != size)
    throw DeviceError(device.path() + ": was asked for " + asked + " and gives " + fourcc_text(got.fourcc) + " " +
                      size_text(got.size) + "; expected what was asked for");
  if (got.field != V4L2_FIELD_NONE && got.field != V4L2_FIELD_ANY)
    throw DeviceError(device.path() + ": gives two half pictures taken one after the other for " + asked +
                      "; expected whole ones (progressive)");
}

}  // namespace

std::int64_t StreamFormat::period_ns() const {
  return rate_hz > 0 ? std::llround(1e9 / rate_hz) : 0;
}

std::string StreamFormat::text() const {
  std::string text = std::string(pixels.name) + " " + size_text(size);
  if (rate_hz <= 0) return text;
  char rate[32];
  std::snprintf(rate, sizeof rate, "%.4g", rate_hz);
  return text + " at " + rate + " Hz";
}

std::vector<PixelFormat> candidates(const Device& device, FormatRequest& request) {
  if (request.size == FrameSize{}) request.size = size_of_now(device);
  const std::vector<OfferedFormat> offered = device.formats();
  struct Candidate {
    PixelFormat pixels;
    double rate_hz;  // the best at this size, as far as more than asked for does not count
  };
  std::vector<Candidate> found;
  for (const PixelFormat& pixels : pixel_formats()) {
    if (!request.format.empty() && request.format != pixels.name) continue;
    const auto offer =
        std::find_if(offered.begin(), offered.end(), [&](const OfferedFormat& f) { return f.fourcc == pixels.fourcc; });
    if (offer == offered.end() || !has_size(*offer, request.size)) continue;
    constexpr double kNearEnough = 0.95;  // 29.97 is 30
    const auto rates = device.rates(pixels.fourcc, request.size);
    const bool enough = !rates || rates->fastest_hz >= kNearEnough * request.rate_hz;
    found.push_back({pixels, enough ? request.rate_hz : rates->fastest_hz});
  }
  if (found.empty())
    throw DeviceError(device.path() + ": has no " + (request.format.empty() ? "" : request.format + " ") +
                      size_text(request.size) + " that pavo reads; it offers " + offer_text(offered));
  std::stable_sort(found.begin(), found.end(),
                   [](const Candidate& a, const Candidate& b) { return a.rate_hz > b.rate_hz; });
  std::vector<PixelFormat> formats;
  formats.reserve(found.size());
  for (const Candidate& candidate : found) formats.push_back(candidate.pixels);
  return formats;
}

StreamFormat set_format(const Device& device, const PixelFormat& pixels, const FormatRequest& request) {
  v4l2_format f = wanted(device, pixels.fourcc, request.size);
  const int result = device.ioctl(VIDIOC_S_FMT, &f);
  if (result == -EBUSY)
    throw DeviceError(device.path() + ": is in use by another program; close that one first", EBUSY);
  if (result < 0)
    throw DeviceError(
        device.path() + ": refuses " + std::string(pixels.name) + " " + size_text(request.size) + ": " + reason(result),
        -result);
  const PlainFormat got = plain(device, f);
  check(device, pixels, request.size, got);
  StreamFormat format{.pixels = pixels, .size = got.size, .bytes_needed = 1};
  if (pixels.row_bytes_x2 > 0) {
    const std::ptrdiff_t row = (std::ptrdiff_t{got.size.width} * pixels.row_bytes_x2 + 1) / 2;
    // Drivers have been seen to leave it 0, and to tell that of the whole picture's planes taken together.
    format.stride = std::max<std::ptrdiff_t>(got.stride, row);
    format.bytes_needed = static_cast<std::size_t>(format.stride * (got.size.height - 1) + row);
  }
  format.rate_hz = set_rate(device, request.rate_hz);
  return format;
}

}  // namespace pavo::v4l2
