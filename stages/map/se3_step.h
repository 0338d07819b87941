// Small motions: T exp(xi) and its inverse, xi = (x y z rx ry rz) in T's own (right) frame.
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "types/pose.h"

namespace pavo {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

inline Eigen::Matrix3d rotation_of(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  if (angle < 1e-12) {
    Eigen::Matrix3d R;
    R << 1, -w.z(), w.y(), w.z(), 1, -w.x(), -w.y(), w.x(), 1;
    return R;
  }
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

/// The rotation vector of R.
inline Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd a(R);
  return a.angle() * a.axis();
}

/// (R Exp(w), t + R v): a retraction, equal to the exponential to first order.
inline SE3 moved_by(const SE3& T, const Vector6d& xi) {
  SE3 result;
  result.R = Eigen::Quaterniond(T.R * rotation_of(xi.tail<3>())).normalized().toRotationMatrix();
  result.t = T.t + T.R * xi.head<3>();
  return result;
}

/// Ad(T): T exp(xi) T^-1 = exp(Ad(T) xi).
inline Matrix6d adjoint(const SE3& T) {
  Eigen::Matrix3d cross;
  cross << 0, -T.t.z(), T.t.y(), T.t.z(), 0, -T.t.x(), -T.t.y(), T.t.x(), 0;
  Matrix6d Ad = Matrix6d::Zero();
  Ad.topLeftCorner<3, 3>() = T.R;
  Ad.topRightCorner<3, 3>() = cross * T.R;
  Ad.bottomRightCorner<3, 3>() = T.R;
  return Ad;
}

/// The xi with moved_by(from, xi) == to.
inline Vector6d step_between(const SE3& from, const SE3& to) {
  Vector6d xi;
  xi.head<3>() = from.R.transpose() * (to.t - from.t);
  xi.tail<3>() = rotation_vector(from.R.transpose() * to.R);
  return xi;
}

}  // namespace pavo
