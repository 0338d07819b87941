#include "drivers/v4l2/camera_session.h"

#include <cerrno>

namespace pavo::v4l2 {

CameraSession::CameraSession(SystemCalls& system, const std::string& path, FormatRequest& request, int buffers,
                             const std::vector<ControlValue>& controls)
    : device_(system, path) {
  const std::vector<PixelFormat> formats = candidates(device_, request);
  set_controls(device_, controls);
  std::optional<DeviceError> first;
  for (const PixelFormat& pixels : formats) {
    try {
      format_ = set_format(device_, pixels, request);
      stream_.emplace(device_, buffers);
      return;
    } catch (const DeviceError& e) {
      if (!first) first = e;
      if (e.code() == EBUSY || e.code() == ENODEV) break;  // no other format would help
    }
  }
  throw DeviceError(*first);
}

}  // namespace pavo::v4l2
