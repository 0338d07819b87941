#include "drivers/calibration/write_calibration.h"

#include <charconv>
#include <stdexcept>

namespace pavo {
namespace {

/// The shortest text that is read back as the same number.
std::string number(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string list(std::initializer_list<double> values) {
  std::string text;
  for (const double v : values) text += (text.empty() ? "[" : ", ") + number(v);
  return text + "]";
}

/// How many of the coefficients the lens's usual name stands for.
int coefficient_count(const Camera& camera, int usual) {
  if (camera.lens == Lens::equidistant) return 4;
  int count = 8;
  while (count > usual && camera.distortion[static_cast<std::size_t>(count - 1)] == 0) --count;
  return count <= usual ? usual : count <= 5 ? 5 : 8;
}

std::string coefficients(const Camera& camera, int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += (i ? ", " : "[") + number(camera.distortion[static_cast<std::size_t>(i)]);
  return text + "]";
}

std::string matrix(const std::string& name, int rows, int columns, const std::string& data) {
  return name + ":\n  rows: " + std::to_string(rows) + "\n  cols: " + std::to_string(columns) + "\n  data: " + data +
         "\n";
}

}  // namespace

std::string ros_camera_info(const Camera& c, const std::string& name) {
  const int count = coefficient_count(c, 5);
  const char* model = c.lens == Lens::equidistant ? "equidistant" : count == 8 ? "rational_polynomial" : "plumb_bob";
  return "image_width: " + std::to_string(c.width) + "\nimage_height: " + std::to_string(c.height) +
         "\ncamera_name: " + name + "\n" +
         matrix("camera_matrix", 3, 3, list({c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1})) + "distortion_model: " + model +
         "\n" + matrix("distortion_coefficients", 1, count, coefficients(c, count)) +
         matrix("rectification_matrix", 3, 3, list({1, 0, 0, 0, 1, 0, 0, 0, 1})) +
         matrix("projection_matrix", 3, 4, list({c.fx, 0, c.cx, 0, 0, c.fy, c.cy, 0, 0, 0, 1, 0}));
}

std::string euroc_sensor(const Camera& c, double rate_hz) {
  std::string text = "sensor_type: camera\n";
  if (rate_hz > 0) text += "rate_hz: " + number(rate_hz) + "\n";
  text += "resolution: [" + std::to_string(c.width) + ", " + std::to_string(c.height) + "]\ncamera_model: pinhole\n";
  text += "intrinsics: " + list({c.fx, c.fy, c.cx, c.cy}) + " # fu, fv, cu, cv\n";
  text +=
      std::string("distortion_model: ") + (c.lens == Lens::equidistant ? "equidistant" : "radial-tangential") + "\n";
  return text + "distortion_coefficients: " + coefficients(c, coefficient_count(c, 4)) + "\n";
}

std::string kitti_projections(const Camera& c) {
  if (c.lens != Lens::rectified)
    throw std::invalid_argument("KITTI's calib.txt is for rectified images; this camera has a lens");
  std::string text;
  for (int i = 0; i < 4; ++i)
    text += "P" + std::to_string(i) + ": " + number(c.fx) + " 0 " + number(c.cx) + " 0 0 " + number(c.fy) + " " +
            number(c.cy) + " 0 0 0 1 0\n";
  return text;
}

}  // namespace pavo
