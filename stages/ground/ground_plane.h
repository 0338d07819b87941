// The ground below a camera, and how the camera is held over it.
//
// In the camera's frame the ground is the plane n.X = d: n points down, d > 0 is the camera's height. A pixel's ray
// x = ((u - cx) / fx, (v - cy) / fy, 1) meets it at the depth 1 / (m.x), where m = n / d: inverse depth is linear in m,
// and |m| is the inverse height. Seen from two places, d is known in units of the way between them.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace pavo {

constexpr double squared(double x) {
  return x * x;
}

/// Attitude of the camera to the ground. Pitch: of the optical axis above the horizon (negative: it looks down).
/// Roll: positive where the right side hangs lower.
struct GroundAttitude {
  double pitch_rad = 0;
  double roll_rad = 0;
};

/// n, the direction down in the camera's frame (x right, y down, z ahead); |n| = 1.
inline Eigen::Vector3d down_of(const GroundAttitude& a) {
  const double c = std::cos(a.pitch_rad);
  return {std::sin(a.roll_rad) * c, std::cos(a.roll_rad) * c, -std::sin(a.pitch_rad)};
}

/// The attitude at which n (of any length) points down: down_of(attitude_of(n)) == n / |n|.
inline GroundAttitude attitude_of(const Eigen::Vector3d& n) {
  return {.pitch_rad = std::atan2(-n.z(), std::hypot(n.x(), n.y())), .roll_rad = std::atan2(n.x(), n.y())};
}

/// d down_of / d (pitch, roll).
inline Eigen::Matrix<double, 3, 2> down_derivative(const GroundAttitude& a) {
  const double sp = std::sin(a.pitch_rad), cp = std::cos(a.pitch_rad);
  const double sr = std::sin(a.roll_rad), cr = std::cos(a.roll_rad);
  Eigen::Matrix<double, 3, 2> D;
  D << -sr * sp, cr * cp,  //
      -cr * sp, -sr * cp,  //
      -cp, 0;
  return D;
}

}  // namespace pavo
