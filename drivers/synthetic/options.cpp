#include "drivers/synthetic/options.h"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

namespace pavo {
namespace {

template <typename T>
void in_range(const char* name, T value, T low, T high) {
  if (value >= low && value <= high) return;  // NaN is not
  std::ostringstream message;
  message << "synthetic street: " << name << " is " << value << ", expected " << low << " to " << high;
  throw std::invalid_argument(message.str());
}

void check_standstills(const std::vector<Standstill>& standstills) {
  int free = 1;
  for (const Standstill& s : standstills) {
    if (s.first < free || s.frames < 1 || s.first > 1'000'000 || s.frames > 1'000'000)
      throw std::invalid_argument("synthetic street: a standstill of " + std::to_string(s.frames) +
                                  " frames at frame " + std::to_string(s.first) +
                                  ", expected at least one frame, from frame " + std::to_string(free) +
                                  " on (rising order, no overlap; the first frame has nothing to stand still after)");
    free = s.first + s.frames;
  }
}

}  // namespace

void check(const SyntheticOptions& o) {
  in_range("frames", o.frames, 1, 100'000);
  in_range("rate_hz", o.rate_hz, 0.1, 1000.0);
  in_range("speed_mps", o.speed_mps, 0.0, 40.0);
  in_range("speed_mps / rate_hz (metres a frame)", o.speed_mps / o.rate_hz, 0.0, 20.0);
  in_range(o.loop ? "hills_m (a loop is level)" : "hills_m", o.hills_m, 0.0, o.loop ? 0.0 : 5.0);
  in_range("width", o.width, 16, 8192);
  in_range("height", o.height, 16, 8192);
  if (o.fx != 0) in_range("fx (0: KITTI's, scaled)", o.fx, 5.0, 20000.0);
  in_range("camera_height_m", o.camera_height_m, 0.2, 3.0);
  in_range("pitch_rad", o.pitch_rad, -0.5, 0.5);
  in_range("noise_sigma", o.noise_sigma, 0.0, 50.0);
  in_range("density", o.density, 0.0, 5.0);
  in_range("companions", o.companions, 0, 30);
  in_range("threads", o.threads, 0, 256);
  for (std::size_t i = 0; i < o.distortion.size(); ++i)
    in_range(("distortion[" + std::to_string(i) + "]").c_str(), o.distortion[i], -100.0, 100.0);
  check_standstills(o.standstills);
}

Camera synthetic_camera(const SyntheticOptions& o) {
  check(o);
  // the principal point of KITTI's cameras, which is not quite in the middle either
  constexpr double kFx = 707.0912, kCx = 601.8873, kCy = 183.1104, kWidth = 1226, kHeight = 370;
  Camera camera;
  camera.width = o.width;
  camera.height = o.height;
  camera.fx = camera.fy = o.fx > 0 ? o.fx : kFx * o.width / kWidth;
  camera.cx = (kCx + 0.5) / kWidth * o.width - 0.5;
  camera.cy = (kCy + 0.5) / kHeight * o.height - 0.5;
  camera.lens = o.lens;
  if (o.lens != Lens::rectified) camera.distortion = o.distortion;
  return camera;
}

}  // namespace pavo
