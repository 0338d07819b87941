// From the fundamental matrix to the camera's motion (Hartley and Zisserman, Multiple View Geometry, 2nd ed., 9.6).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "stages/matches/matches.h"
#include "types/camera.h"
#include "types/pose.h"

namespace pavo {

/// [v]x: [v]x w = v x w.
Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v);

Eigen::Matrix3d intrinsic_matrix(const Camera& camera);

/// E = K^T F K, its singular values repaired to (1, 1, 0).
Eigen::Matrix3d essential_from_fundamental(const Eigen::Matrix3d& F, const Camera& camera);

/// E = [t]x R.
Eigen::Matrix3d essential_of(const SE3& T_c_p);

/// The four motions T_c_p (points of the previous camera into the current one), |t| = 1, that E allows.
std::array<SE3, 4> motions_of(const Eigen::Matrix3d& E);

/// Depths of the point that a pair of rays sees, along the previous and the current camera's z axis, where the rays are
/// (x/z, y/z, 1): least squares of depth_c ray_c = R depth_p ray_p + t. Infinite for parallel rays.
struct Depths {
  double previous = 0, current = 0;
};
Depths triangulate_depths(const SE3& T_c_p, const Eigen::Vector3d& ray_p, const Eigen::Vector3d& ray_c);

/// How far the pair moved beyond what the rotation does to it, in pixels: what tells of the translation.
double parallax_px(const SE3& T_c_p, const PointPair& pair, const Camera& camera);

struct InFront {
  SE3 T_c_p;
  int in_front = 0;  ///< pairs that lie in front of both cameras, of those that were asked
  int asked = 0;     ///< pairs whose parallax is large enough to tell
};

/// The candidate that the fewest used pairs contradict, by lying behind a camera. Points without parallax (fewer than
/// min_parallax_px, by the candidate's rotation) are not asked, unless nearly all are such.
InFront motion_in_front(const Eigen::Matrix3d& E, std::span<const PointPair> pairs, std::span<const std::uint8_t> use,
                        const Camera& camera, double min_parallax_px);

}  // namespace pavo
