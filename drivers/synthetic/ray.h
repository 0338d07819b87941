// A pixel's ray and its neighbours', and the names of what a ray can meet.
#pragma once

#include "drivers/synthetic/renderer.h"

namespace pavo::synthetic {

enum : std::uint32_t { kSky, kRoad, kKerbFace, kSidewalk, kField, kNothing, kFirstPart = 16 };

inline std::uint32_t part_id(std::uint32_t part, int face) {
  return kFirstPart + 16 * part + static_cast<std::uint32_t>(face);
}
inline std::uint32_t part_of(std::uint32_t id) {
  return (id - kFirstPart) / 16;
}
inline std::uint32_t face_of(std::uint32_t id) {
  return (id - kFirstPart) % 16;
}

/// In the plane z = 1 of the camera: where the pixel looks, and how far its right and lower neighbours look away.
struct Renderer::Ray {
  Ray(const Scene& the_scene, const RayTable& rays, int x, int y) : scene(&the_scene), p(rays.at(x, y)) {
    dx = rays.at(x + 1, y) - p;
    dy = rays.at(x, y + 1) - p;
    if (!(dx.squaredNorm() < 1)) dx = p - rays.at(x - 1, y);  // at the rim of what the lens sees
    if (!(dy.squaredNorm() < 1)) dy = p - rays.at(x, y - 1);
  }
  Eigen::Vector2f at(float i, float j) const { return p + i * dx + j * dy; }
  Ray moved(float i, float j) const {
    Ray ray = *this;
    ray.p = at(i, j);
    return ray;
  }
  float pixel() const { return dx.norm(); }
  /// The direction in a frame into which B maps the camera's.
  Eigen::Vector3f in(const Eigen::Matrix3f& B) const { return B.col(0) * p.x() + B.col(1) * p.y() + B.col(2); }
  static Eigen::Vector3f change(const Eigen::Matrix3f& B, const Eigen::Vector2f& d) {
    return B.col(0) * d.x() + B.col(1) * d.y();
  }

  const Scene* scene;
  Eigen::Vector2f p, dx, dy;
};

}  // namespace pavo::synthetic
