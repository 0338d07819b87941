// The lens formulas of Camera, forwards and backwards: what the undistortion undoes and the renderer does.
//
// radial_tangential (Brown 1966; the rational form as in OpenCV): with r^2 = x^2 + y^2 and
//     c = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6),
//     x' = c x + 2 p1 x y + p2 (r^2 + 2 x^2),   y' = c y + p1 (r^2 + 2 y^2) + 2 p2 x y.
// equidistant (Kannala and Brandt, PAMI 2006): with theta = atan2(r, z),
//     theta' = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8),   (x', y') = theta' / r (x, y).
//
// All functions are pure: any thread, no allocation, no blocking.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "types/camera.h"

namespace pavo {

namespace lens_detail {

/// c(r^2) of the radial-tangential lens and its derivative by r^2.
struct Radial {
  double c = 1;
  double derivative = 0;
};

inline Radial radial(const std::array<double, 8>& k, double r2) {
  const double n = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  const double d = 1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]));
  const double dn = k[0] + r2 * (2 * k[1] + r2 * 3 * k[4]);
  const double dd = k[5] + r2 * (2 * k[6] + r2 * 3 * k[7]);
  return {n / d, (dn * d - n * dd) / (d * d)};
}

/// theta' of the equidistant lens.
inline double bent_angle(const std::array<double, 8>& k, double theta) {
  const double t2 = theta * theta;
  return theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
}

inline double bent_angle_derivative(const std::array<double, 8>& k, double theta) {
  const double t2 = theta * theta;
  return 1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])));
}

/// How fast the distorted radius grows at `r`: the ideal radius, or the angle in radians of an equidistant lens.
inline double radial_growth(const Camera& camera, double r) {
  if (camera.lens == Lens::equidistant) return bent_angle_derivative(camera.distortion, r);
  if (camera.lens == Lens::rectified) return 1;
  const double r2 = r * r;
  const double d = 1 + r2 * (camera.distortion[5] + r2 * (camera.distortion[6] + r2 * camera.distortion[7]));
  if (d <= 0) return -1;  // beyond a pole of the rational form
  const Radial c = radial(camera.distortion, r2);
  return c.c + 2 * r2 * c.derivative;
}

inline bool grows_up_to(const Camera& camera, double r) {
  constexpr int kSamples = 24;
  for (int i = 1; i <= kSamples; ++i)
    if (!(radial_growth(camera, r * i / kSamples) > 0)) return false;
  return true;
}

}  // namespace lens_detail

/// (X/Z, Y/Z) to the distorted point of the image plane.
inline Eigen::Vector2d distort(const Camera& camera, const Eigen::Vector2d& p) {
  const std::array<double, 8>& k = camera.distortion;
  if (camera.lens == Lens::radial_tangential) {
    const double x = p.x(), y = p.y(), r2 = x * x + y * y;
    const double c = lens_detail::radial(k, r2).c;
    return {c * x + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x), c * y + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y};
  }
  if (camera.lens == Lens::equidistant) {
    const double r = p.norm();
    return r < 1e-12 ? p : Eigen::Vector2d(p * (lens_detail::bent_angle(k, std::atan(r)) / r));
  }
  return p;
}

/// The ideal radius (an equidistant lens: the angle in radians) up to which the formula is a lens: beyond it the
/// polynomial turns back, and points far outside the field of view would fall into the picture again. Infinite where it
/// never does within 84 degrees of the axis (equidistant: pi within a half turn). Scans the formula: not for every
/// pixel.
inline double lens_limit(const Camera& camera) {
  const bool angle = camera.lens == Lens::equidistant;
  const double end = angle ? std::numbers::pi : 10.0;
  constexpr int kSteps = 4000;
  for (int i = 1; i <= kSteps; ++i)
    if (!(lens_detail::radial_growth(camera, end * i / kSteps) > 0)) return end * (i - 1) / kSteps;
  return angle ? end : std::numeric_limits<double>::infinity();
}

/// The pixel where a point of the camera's frame is seen. z > 0, except for an equidistant lens, which also sees
/// sideways and back. Nothing says whether the pixel is inside the image.
inline Eigen::Vector2d project(const Camera& camera, const Eigen::Vector3d& point) {
  Eigen::Vector2d p;
  if (camera.lens == Lens::equidistant) {
    const Eigen::Vector2d xy = point.head<2>();
    const double r = xy.norm();
    const double bent = lens_detail::bent_angle(camera.distortion, std::atan2(r, point.z()));
    p = r < 1e-12 ? Eigen::Vector2d(0, 0) : Eigen::Vector2d(xy * (bent / r));
  } else {
    p = distort(camera, point.head<2>() / point.z());
  }
  return {camera.fx * p.x() + camera.cx, camera.fy * p.y() + camera.cy};
}

namespace lens_detail {

/// Newton's method from the distorted point; nothing where it finds no point on the lens's growing branch.
inline std::optional<Eigen::Vector2d> straighten_radial_tangential(const Camera& camera,
                                                                   const Eigen::Vector2d& target) {
  const std::array<double, 8>& k = camera.distortion;
  double x = target.x(), y = target.y();
  for (int iteration = 0; iteration < 50; ++iteration) {
    const Eigen::Vector2d error = distort(camera, {x, y}) - target;
    if (error.squaredNorm() < 1e-26) break;
    const Radial c = radial(k, x * x + y * y);
    const double xx = c.c + 2 * x * x * c.derivative + 2 * k[2] * y + 6 * k[3] * x;
    const double xy = 2 * x * y * c.derivative + 2 * k[2] * x + 2 * k[3] * y;
    const double yy = c.c + 2 * y * y * c.derivative + 6 * k[2] * y + 2 * k[3] * x;
    const double determinant = xx * yy - xy * xy;
    if (!(std::abs(determinant) > 1e-12)) return std::nullopt;
    x -= (yy * error.x() - xy * error.y()) / determinant;
    y -= (xx * error.y() - xy * error.x()) / determinant;
  }
  const Eigen::Vector2d p(x, y);
  if (!((distort(camera, p) - target).norm() < 1e-9) || !grows_up_to(camera, p.norm())) return std::nullopt;
  return p;
}

inline std::optional<double> straighten_angle(const Camera& camera, double bent) {
  double theta = bent;
  for (int iteration = 0; iteration < 50; ++iteration) {
    const double error = bent_angle(camera.distortion, theta) - bent;
    if (std::abs(error) < 1e-14) break;
    theta -= error / bent_angle_derivative(camera.distortion, theta);
  }
  const bool found = std::abs(bent_angle(camera.distortion, theta) - bent) < 1e-9;
  if (!found || theta < 0 || theta > std::numbers::pi || !grows_up_to(camera, theta)) return std::nullopt;
  return theta;
}

}  // namespace lens_detail

/// The direction (unit length, in the camera's frame) that is seen at a pixel: project(camera, *unproject(camera, u))
/// == u. Nothing where the lens sees nothing there (the formula never reaches that pixel).
inline std::optional<Eigen::Vector3d> unproject(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d target((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy);
  if (camera.lens == Lens::rectified) return Eigen::Vector3d(target.x(), target.y(), 1).normalized();
  if (camera.lens == Lens::equidistant) {
    const double bent = target.norm();
    if (bent < 1e-12) return Eigen::Vector3d::UnitZ();
    const std::optional<double> theta = lens_detail::straighten_angle(camera, bent);
    if (!theta) return std::nullopt;
    const Eigen::Vector2d side = target / bent * std::sin(*theta);
    return Eigen::Vector3d(side.x(), side.y(), std::cos(*theta));
  }
  const std::optional<Eigen::Vector2d> p = lens_detail::straighten_radial_tangential(camera, target);
  if (!p) return std::nullopt;
  return Eigen::Vector3d(p->x(), p->y(), 1).normalized();
}

}  // namespace pavo
