// The camera as it turns out to be: what a calibration leaves over is small, but the same in every frame.
//
// A radial error of a few thousandths makes points that come nearer seem nearer or farther than they are, always the
// same way, so that the scale of what is seen later drifts by some percent in 100 m. Two numbers describe it: the
// logarithm of a factor of the focal length, and one coefficient of radial distortion, k1. The map estimates them
// along.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "types/camera.h"

namespace pavo {

/// (ln focal factor, k1); (0, 0): the camera is as it was calibrated.
using LensError = Eigen::Vector2d;

/// `rectified` with that error: Lens::radial_tangential, of which the functions here know k1 only.
inline Camera refined_camera(const Camera& rectified, const LensError& error) {
  Camera camera = rectified;
  const double factor = std::exp(error(0));
  camera.fx *= factor, camera.fy *= factor;
  camera.lens = Lens::radial_tangential;
  camera.distortion[0] = error(1);
  return camera;
}

constexpr double kWidestRadius2 = 4;  // a half angle of 63 degrees

/// x^2 + y^2 of the image plane as the distortion knows it: outside of any picture it stays what it is at the border.
inline double radius2(double x, double y) {
  return std::min(x * x + y * y, kWidestRadius2);
}

/// Pixel of a (scaled) point in the camera's frame; z > 0.
inline Eigen::Vector2d pixel_of(const Camera& camera, const Eigen::Vector3d& p) {
  const double x = p.x() / p.z(), y = p.y() / p.z();
  const double s = 1 + camera.distortion[0] * radius2(x, y);
  return {camera.fx * s * x + camera.cx, camera.fy * s * y + camera.cy};
}

/// d pixel / d p.
inline Eigen::Matrix<double, 2, 3> pixel_jacobian(const Camera& camera, const Eigen::Vector3d& p) {
  const double inverse_z = 1 / p.z(), x = p.x() * inverse_z, y = p.y() * inverse_z, k = camera.distortion[0];
  const double s = 1 + k * radius2(x, y), xx = s + 2 * k * x * x, xy = 2 * k * x * y, yy = s + 2 * k * y * y;
  Eigen::Matrix<double, 2, 3> J;
  J << xx, xy, -(xx * x + xy * y),  //
      xy, yy, -(xy * x + yy * y);
  J.row(0) *= camera.fx * inverse_z;
  J.row(1) *= camera.fy * inverse_z;
  return J;
}

/// d pixel / d LensError.
inline Eigen::Matrix2d lens_jacobian(const Camera& camera, const Eigen::Vector3d& p) {
  const double x = p.x() / p.z(), y = p.y() / p.z(), r2 = radius2(x, y);
  const double s = 1 + camera.distortion[0] * r2;
  Eigen::Matrix2d J;
  J << camera.fx * s * x, camera.fx * r2 * x,  //
      camera.fy * s * y, camera.fy * r2 * y;
  return J;
}

/// The ray of a pixel, z = 1: pixel_of()'s inverse, by iteration (the distortion is small).
inline Eigen::Vector3d ray_of(const Camera& camera, double u, double v) {
  const double x_distorted = (u - camera.cx) / camera.fx, y_distorted = (v - camera.cy) / camera.fy;
  double x = x_distorted, y = y_distorted;
  for (int i = 0; i < 6 && camera.distortion[0] != 0; ++i) {
    const double s = 1 + camera.distortion[0] * radius2(x, y);
    x = x_distorted / s, y = y_distorted / s;
  }
  return {x, y, 1};
}

}  // namespace pavo
