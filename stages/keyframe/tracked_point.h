// A point that the odometry follows from frame to frame.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "stages/features/features.h"
#include "stages/map/map_messages.h"
#include "stages/matches/align_patch.h"

namespace pavo {

struct TrackedPoint {
  PointId id = 0;  ///< 0: a free place
  RayPoint ray;
  Patch patch;
  Eigen::Vector3d patch_position, patch_axis;  ///< of the camera that the patch is from, and its optical axis; world
  std::array<float, Features::kDescriptorSize> descriptor;
  Eigen::Vector2f last_px;      ///< where it was seen last
  Eigen::Vector2f still_px;     ///< in the frame that a standstill is measured from
  Eigen::Vector2f keyframe_px;  ///< in the last keyframe
  bool in_still = false, in_keyframe = false;
  bool in_map = false;  ///< the map knows it
  int seen = 0;         ///< frames that it was found in
  int misses = 0;       ///< in a row
  int outliers = 0;     ///< how often it did not fit, less how often it did
  // In this frame:
  enum class Now : std::uint8_t { hidden, searched, found, fits } now = Now::hidden;
  Eigen::Vector2f px;

  /// How large the patch is to be drawn for a camera there.
  double patch_scale(const SE3& T_w_c) const {
    const Eigen::Vector3d then = ray.direction + ray.rho * (ray.origin - patch_position);
    const Eigen::Vector3d here = ray.direction + ray.rho * (ray.origin - T_w_c.t);
    return patch_axis.dot(then) / T_w_c.R.col(2).dot(here);
  }
};

}  // namespace pavo
