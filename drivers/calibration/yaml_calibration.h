// The YAML formats among the calibrations: EuRoC, ROS and OpenCV.
#pragma once

#include <string>
#include <string_view>

#include "drivers/calibration/calibration.h"

namespace pavo {

/// As parse_calibration(), for a text that is not KITTI's.
Calibration parse_yaml_calibration(std::string_view text, const std::string& name);

}  // namespace pavo
