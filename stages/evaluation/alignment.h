// Laying one path over another: the similarity that maps an estimate's world into the truth's.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "stages/evaluation/association.h"
#include "types/pose.h"

namespace pavo {

enum class Alignment {
  none,   ///< the first poses coincide, nothing else is touched
  scale,  ///< the first poses coincide; one scale s minimises sum |s e_i - g_i|^2 (positions from the first camera)
  se3,    ///< the rotation and translation that minimise sum |R e_i + t - g_i|^2
  sim3,   ///< the scale, rotation and translation that minimise sum |s R e_i + t - g_i|^2
};

/// p_truth = scale * R * p_estimate + t.
struct Similarity {
  double scale = 1;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  /// false: one of the paths stands still (or, for `scale`, no positive scale makes it better): `scale` is 1 and means
  /// nothing. Always false for the alignments without a scale.
  bool scale_known = false;

  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return scale * (R * p) + t; }
  SE3 operator*(const SE3& T_w_c) const { return {R * T_w_c.R, *this * T_w_c.t}; }
};

/// se3 and sim3 by Umeyama, "Least-squares estimation of transformation parameters between two point patterns" (PAMI
/// 1991), equations 34 to 43, of the camera centres. On a straight path the roll about it is arbitrary (but the same on
/// every run): positions can be compared then, rotations cannot. Needs one pair or more (std::invalid_argument).
Similarity align(const PosePairs& pairs, Alignment alignment);

/// The whole path in the other world, with its times.
Trajectory transformed(const Similarity& similarity, const Trajectory& trajectory);

}  // namespace pavo
