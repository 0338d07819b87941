// Camera calibrations as the files that others read, too.
#pragma once

#include <string>

#include "types/camera.h"

namespace pavo {

/// Every number is written with the digits that bring back the same bits, whatever the locale; read_calibration() gives
/// the same camera. Pure; any thread.

/// ROS's camera_info YAML (camera_calibration_parsers): plumb_bob, rational_polynomial or equidistant; P is K. `name`
/// is the camera's: letters, digits and '_'.
std::string ros_camera_info(const Camera& camera, const std::string& name);

/// EuRoC's sensor.yaml, without the camera's place in a body. `rate_hz`: 0 where it is not known.
std::string euroc_sensor(const Camera& camera, double rate_hz);

/// KITTI odometry's calib.txt, P0 to P3 alike: only for a rectified camera (throws std::invalid_argument).
std::string kitti_projections(const Camera& camera);

}  // namespace pavo
