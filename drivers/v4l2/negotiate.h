// What the camera shall deliver, and what its driver makes of that.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "drivers/v4l2/device.h"

namespace pavo::v4l2 {

struct FormatRequest {
  FrameSize size;       ///< 0x0: the one that the camera stands at
  double rate_hz = 30;  ///< the driver takes the nearest that it has
  std::string format;   ///< "YUYV"; "": the one that pavo likes best of those that are fast enough
};

/// What was agreed upon: read back from the driver, which may change whatever it is asked for.
struct StreamFormat {
  PixelFormat pixels{};
  FrameSize size;
  std::ptrdiff_t stride = 0;       ///< bytes from one row to the next; 0: compressed
  std::size_t bytes_needed = 0;    ///< of a complete frame's first plane; 1: compressed
  double rate_hz = 0;              ///< 0: the driver does not tell
  std::int64_t period_ns() const;  ///< by that rate; 0 without one
  std::string text() const;        ///< "YUYV 640x480 at 30 Hz"
};

/// The pixel formats to try, the best first: those that reach the rate at this size, in the order of pixel_formats();
/// behind them the others, by their rate (a camera on USB 2 has 1280x720 ten times a second as YUYV, thirty as MJPEG).
/// Fills in the size where none is asked for. Throws DeviceError, with what there is, where nothing fits.
std::vector<PixelFormat> candidates(const Device& device, FormatRequest& request);

/// Sets format and rate, and reads back. Throws DeviceError where the driver makes something else of it: another size
/// (no calibration would fit), other pixels, two half pictures.
StreamFormat set_format(const Device& device, const PixelFormat& pixels, const FormatRequest& request);

}  // namespace pavo::v4l2
