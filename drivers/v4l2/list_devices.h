// The cameras of this machine.
#pragma once

#include <string>
#include <vector>

#include "drivers/v4l2/controls.h"
#include "drivers/v4l2/device.h"

namespace pavo::v4l2 {

struct FoundDevice {
  std::string path;
  std::string problem;  ///< why it is no camera, or cannot be asked; then nothing below but, perhaps, the name
  DeviceName name;
  struct Size {
    SizeRange range;
    std::vector<double> rates_hz;  ///< one by one, or slowest and fastest; empty: the driver does not tell
    bool any_between = false;      ///< `rates_hz` are slowest and fastest
  };
  struct Format {
    std::uint32_t fourcc = 0;
    std::string description;
    bool readable = false;  ///< by pavo
    std::vector<Size> sizes;
  };
  std::vector<Format> formats;
  std::vector<Control> controls;
};

/// Asks one node.
FoundDevice describe_device(SystemCalls& system, const std::string& path);

/// The nodes /dev/video0, 1, ... of `folder`, in the order of their numbers. Those that are no cameras are among them,
/// with their problem.
std::vector<std::string> device_nodes(const std::string& folder = "/dev");

}  // namespace pavo::v4l2
