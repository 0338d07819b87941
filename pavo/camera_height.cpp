#include <charconv>
#include <cmath>
#include <stdexcept>

#include "pavo/config.h"

namespace pavo {
namespace {

constexpr std::string_view kName = "camera-height";

double height_in(std::string_view text) {
  double height = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), height);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(height) || height <= 0)
    throw std::runtime_error(
        "--scale camera-height=" + std::string(text.substr(0, 40)) +
        " (odometry.scale): expected the camera's height above the ground in metres, such as 1.65");
  return height;
}

}  // namespace

bool scale_from_camera_height(const Config& config) {
  const std::string_view scale = config.odometry.scale;
  return scale == kName || scale.starts_with("camera-height=");
}

void settle_camera_height(Config& config) {
  if (!scale_from_camera_height(config)) return;
  const std::string_view scale = config.odometry.scale;
  if (scale != kName) {
    const double height = height_in(scale.substr(kName.size() + 1));
    if (config.camera.height_m > 0 && config.camera.height_m != height)
      throw std::runtime_error(
          "--scale (odometry.scale) and --camera-height (camera.height_m) tell two different heights");
    config.camera.height_m = height;
  }
  if (!(config.camera.height_m > 0))
    throw std::runtime_error(
        "--scale camera-height (odometry.scale) needs the camera's height: --scale camera-height=METRES, or "
        "--camera-height METRES");
}

}  // namespace pavo
