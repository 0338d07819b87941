#include "drivers/publishing/pose_line.h"

#include <Eigen/Geometry>
#include <charconv>
#include <cmath>

namespace pavo {
namespace {

template <typename Number>
void append(std::string& line, Number value) {
  char text[32];
  line.append(text, std::to_chars(text, text + sizeof text, value).ptr);
}

void append(std::string& line, std::string_view name, std::initializer_list<double> values) {
  line += '"';
  line += name;
  line += "\":[";
  bool first = true;
  for (const double v : values) {
    if (!first) line += ',';
    first = false;
    append(line, std::isfinite(v) ? v : 0.0);  // JSON has no others, and no pose is any other
  }
  line += ']';
}

}  // namespace

void append_pose_line(std::string& line, const PublishedPose& pose) {
  Eigen::Quaterniond q(pose.T_world_camera.R);
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const Eigen::Vector3d& t = pose.T_world_camera.t;
  line += "{\"frame\":";
  append(line, pose.frame);
  line += ",\"t_capture_ns\":";
  append(line, pose.t_capture_ns);
  line += ",\"age_ms\":";
  append(line, std::round(pose.age_ms * 1e3) / 1e3);
  line += ",\"T_world_camera\":{";
  append(line, "position", {t.x(), t.y(), t.z()});
  line += ',';
  append(line, "quaternion", {q.x(), q.y(), q.z(), q.w()});
  line += "},\"quality\":\"";
  line += pose.quality;
  line += "\"}\n";
}

}  // namespace pavo
