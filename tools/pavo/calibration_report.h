// What `pavo calibrate` says about a calibration, and writes beside it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "stages/calibration/calibrate_camera.h"

namespace pavo {

struct CalibrationReport {
  const CalibrationResult& result;
  const Board& board;
  const std::vector<BoardCorners>& views;
  const std::vector<std::string>& names;  ///< of the views: files, or "view 3"
};

/// The parameters with their standard deviations, RMS, and the views.
std::string calibration_table(const CalibrationReport& report);
/// What makes the calibration doubtful, in words.
std::vector<std::string> calibration_warnings(const CalibrationReport& report);
nlohmann::ordered_json calibration_json(const CalibrationReport& report);
/// Where in the image the corners were, and how far (enlarged) from where the calibration puts them: an SVG.
std::string calibration_picture(const CalibrationReport& report);
/// ROS's camera_info YAML, with the standard deviations as comments.
std::string calibration_yaml(const CalibrationReport& report, const std::string& camera_name);

}  // namespace pavo
