// Pictures of a road, rendered by ray: everything about them is known.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>

#include "stages/ground/ground_plane.h"
#include "types/camera.h"
#include "types/image.h"
#include "types/pose.h"

namespace pavo::roads {

inline Camera camera() {
  Camera c;
  c.width = 480, c.height = 180;
  c.fx = c.fy = 300, c.cx = 239.5, c.cy = 79.5;
  return c;
}

/// Smooth noise over the plane: a hash on a grid, interpolated.
inline double texture(double x, double y, std::uint32_t seed) {
  const auto hash = [seed](std::int64_t i, std::int64_t j) {
    std::uint64_t h = static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15ull ^
                      static_cast<std::uint64_t>(j) * 0xC2B2AE3D27D4EB4Full ^ (seed * 0x165667B19E3779F9ull);
    h = (h ^ (h >> 31)) * 0xBF58476D1CE4E5B9ull;
    return static_cast<double>((h ^ (h >> 29)) & 0xFFFF) / 65535.0;
  };
  const double fx = std::floor(x), fy = std::floor(y);
  const auto i = static_cast<std::int64_t>(fx), j = static_cast<std::int64_t>(fy);
  const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
  const double u = smooth(x - fx), v = smooth(y - fy);
  return (1 - v) * ((1 - u) * hash(i, j) + u * hash(i + 1, j)) +
         v * ((1 - u) * hash(i, j + 1) + u * hash(i + 1, j + 1));
}

/// A road at y = height_m below the first camera's place, in a frame whose y points down and whose z is the way ahead;
/// T_road_camera is the camera's pose there. What is not road is an even gray.
struct Road {
  double height_m = 1.5;
  double grain_m = 0.12;
  double contrast = 60;
  std::uint32_t seed = 1;

  Image seen_from(const SE3& T_road_camera, const Camera& c = camera()) const {
    Image image(c.width, c.height);
    for (int y = 0; y < c.height; ++y)
      for (int x = 0; x < c.width; ++x) {
        const Eigen::Vector3d ray = T_road_camera.R * Eigen::Vector3d((x - c.cx) / c.fx, (y - c.cy) / c.fy, 1);
        double value = 120;
        const double depth = (height_m - T_road_camera.t.y()) / ray.y();
        if (ray.y() > 0 && depth < 60) {
          const Eigen::Vector3d p = T_road_camera.t + depth * ray;
          value = 90 + contrast * (texture(p.x() / grain_m, p.z() / grain_m, seed) +
                                   texture(p.x() / (4 * grain_m), p.z() / (4 * grain_m), seed + 7) - 1);
        }
        image.at(x, y) = static_cast<std::uint8_t>(std::lround(std::min(255.0, std::max(0.0, value))));
      }
    return image;
  }
};

/// A camera on the road, held so, after `metres` ahead; the road's frame.
inline SE3 on_the_way(double metres, const GroundAttitude& held = {}, double yaw_rad = 0) {
  // Columns: the camera's axes in the road's frame. down_of() is the road's down in the camera's frame.
  const Eigen::Vector3d down = down_of(held);
  SE3 T;
  const Eigen::Matrix3d upright = Eigen::Quaterniond::FromTwoVectors(down, Eigen::Vector3d::UnitY()).toRotationMatrix();
  T.R = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitY()).toRotationMatrix() * upright;
  T.t = Eigen::Vector3d(0, 0, metres);
  return T;
}

}  // namespace pavo::roads
