// Rigid motions, and the path that a camera took.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace pavo {

/// A rigid motion. T_a_b maps points of frame b into frame a: p_a = R p_b + t, so T_a_c = T_a_b * T_b_c.
struct SE3 {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();

  SE3 inverse() const { return {R.transpose(), -(R.transpose() * t)}; }
  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return R * p + t; }
  SE3 operator*(const SE3& other) const { return {R * other.R, R * other.t + t}; }
};

/// Camera poses over time. The camera looks along +z, x right, y down; the world is the first camera's frame.
struct Trajectory {
  std::vector<SE3> T_w_c;
  std::vector<std::int64_t> t_ns;  ///< one per pose, or empty where the file has no times
};

}  // namespace pavo
