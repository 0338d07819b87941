// A camera that streams: its node, what was agreed upon, and the running buffers, from open to close.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/v4l2/controls.h"
#include "drivers/v4l2/negotiate.h"
#include "drivers/v4l2/stream.h"

namespace pavo::v4l2 {

class CameraSession {
 public:
  /// Opens, sets the controls, and starts the best of the formats that the driver can start: where one is refused (by
  /// the driver, or for want of USB bandwidth), the next one is tried. Fills in `request.size` where it is 0x0. Throws
  /// DeviceError: of several formats, the first one's.
  CameraSession(SystemCalls& system, const std::string& path, FormatRequest& request, int buffers,
                const std::vector<ControlValue>& controls);
  CameraSession(const CameraSession&) = delete;
  CameraSession& operator=(const CameraSession&) = delete;

  const Device& device() const { return device_; }
  const StreamFormat& format() const { return format_; }
  Stream& stream() { return *stream_; }

 private:
  Device device_;
  StreamFormat format_;
  std::optional<Stream> stream_;  // after the device, which it uses
};

}  // namespace pavo::v4l2
