// A pose as it is published: one line of JSON.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "types/pose.h"

namespace pavo {

struct PublishedPose {
  std::int64_t frame = 0;         ///< as in frames.csv
  std::int64_t t_capture_ns = 0;  ///< a camera's: CLOCK_MONOTONIC
  double age_ms = 0;              ///< from the sensor's stamp to this line
  SE3 T_world_camera;
  std::string_view quality;  ///< "tracked", "standing", "coasting", "relocalising"
};

/// Appends to `line` (which keeps its capacity)
///   {"frame":7,"t_capture_ns":123,"age_ms":4.2,"T_world_camera":{"position":[x,y,z],"quaternion":[x,y,z,w]},"quality":"tracked"}
/// and '\n'. w >= 0; numbers have the digits that bring back the same bits.
void append_pose_line(std::string& line, const PublishedPose& pose);

}  // namespace pavo
