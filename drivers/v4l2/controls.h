// What can be turned on a camera: exposure, gain, white balance, focus; by the names that v4l2-ctl shows.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/v4l2/device.h"

namespace pavo::v4l2 {

enum class ControlKind : std::uint8_t { whole_number, yes_no, menu, button, other };

struct Control {
  std::uint32_t id = 0;
  std::string name;   ///< "exposure_time_absolute"
  std::string title;  ///< "Exposure Time, Absolute"
  ControlKind kind = ControlKind::other;
  std::int64_t minimum = 0, maximum = 0, step = 1, fallback = 0;
  std::int64_t value = 0;
  bool read_only = false;
  bool inactive = false;  ///< without effect now, such as the exposure while it is automatic
  std::vector<std::pair<std::int64_t, std::string>> choices;  ///< of a menu
};

/// All of the camera's controls, with their values of now.
std::vector<Control> controls_of(const Device& device);

/// "name=value, name=value": in the order in which they are set, since some wake others up ("auto_exposure=1" first,
/// "exposure_time_absolute=50" behind it). A value is a number, true or false, or what a menu calls it.
struct ControlValue {
  std::string name, value;
};
/// Throws std::runtime_error of one line.
std::vector<ControlValue> parse_controls(std::string_view text);

/// Sets them one by one. Throws DeviceError that says which one failed, and what it may be.
void set_controls(const Device& device, const std::vector<ControlValue>& values);

}  // namespace pavo::v4l2
