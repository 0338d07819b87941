// A point of the map: on a ray, at an inverse distance, so that what is far away is as regular as what is near.
#pragma once

#include <Eigen/Core>

#include "stages/map/refined_camera.h"
#include "types/pose.h"

namespace pavo {

/// X = origin + direction / rho, world frame. `origin` is where the point was first seen from, and direction has length
/// 1 along that camera's axis, so that rho is the inverse depth there (Civera, Davison and Montiel, TRO 2008; here the
/// host's pose is not part of the point). rho = 0: at infinity; a negative rho (behind the host) is no point.
struct RayPoint {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  double rho = 0;
  double sigma_rho = 1;  ///< standard deviation of rho
};

/// The point in the camera's frame, times rho: finite at infinity too.
inline Eigen::Vector3d scaled_in_camera(const RayPoint& p, const SE3& T_w_c) {
  return T_w_c.R.transpose() * (p.direction + p.rho * (p.origin - T_w_c.t));
}

/// d pixel / d xi for T_w_c <- T_w_c exp(xi), xi = (x y z rx ry rz): dp = -rho v + p x w.
inline Eigen::Matrix<double, 2, 6> pose_jacobian(const Eigen::Matrix<double, 2, 3>& by_point, const Eigen::Vector3d& p,
                                                 double rho) {
  Eigen::Matrix<double, 2, 6> J;
  J.leftCols<3>() = -rho * by_point;
  Eigen::Matrix3d cross;
  cross << 0, -p.z(), p.y(), p.z(), 0, -p.x(), -p.y(), p.x(), 0;
  J.rightCols<3>() = by_point * cross;
  return J;
}

/// The same point seen from another origin; `axis`: the direction along which the new direction has length 1.
inline RayPoint rehosted(const RayPoint& p, const Eigen::Vector3d& origin, const Eigen::Vector3d& axis) {
  const Eigen::Vector3d v = p.direction + p.rho * (p.origin - origin);
  const double depth = v.dot(axis);
  return {origin, v / depth, p.rho / depth, p.sigma_rho / depth};
}

}  // namespace pavo
