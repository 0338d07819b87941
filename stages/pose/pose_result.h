// What the odometry says about one frame: where the camera is, how sure that is, and what it was decided from.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "stages/ground/ground_plane.h"
#include "stages/matches/matches.h"
#include "types/pose.h"

namespace pavo {

enum class Quality : std::uint8_t {
  tracked,       ///< estimated from the image
  standing,      ///< the image did not move: the pose is the previous one, to the bit
  coasting,      ///< not estimated: the motion model's pose
  relocalising,  ///< kept for estimators that can lose and find their map; frame-to-frame never says it
};

/// Why the quality is what it is; `none` for a plainly tracked frame.
enum class PoseReason : std::uint8_t {
  none,
  first_frame,           ///< nothing to compare with: the identity
  standstill,            ///< enough matches did not move
  rotation_only,         ///< tracked, but no parallax: the direction of the translation is the motion model's
  too_few_keypoints,     ///< the image has (almost) no corners
  too_few_after_people,  ///< it had enough of them before those on people were dropped
  no_reference,          ///< no earlier frame to match it against
  too_few_matches,
  too_few_inliers,  ///< no motion explains enough of the matches
  missed,           ///< the frame failed before it came here
};

constexpr std::string_view name_of(Quality quality) {
  switch (quality) {
    case Quality::tracked:
      return "tracked";
    case Quality::standing:
      return "standing";
    case Quality::coasting:
      return "coasting";
    case Quality::relocalising:
      return "relocalising";
  }
  return "?";
}

constexpr std::string_view name_of(PoseReason reason) {
  switch (reason) {
    case PoseReason::none:
      return "";
    case PoseReason::first_frame:
      return "first frame";
    case PoseReason::standstill:
      return "standstill";
    case PoseReason::rotation_only:
      return "rotation only";
    case PoseReason::too_few_keypoints:
      return "too few keypoints";
    case PoseReason::too_few_after_people:
      return "too few keypoints beside people";
    case PoseReason::no_reference:
      return "no frame to match against";
    case PoseReason::too_few_matches:
      return "too few matches";
    case PoseReason::too_few_inliers:
      return "too few inliers";
    case PoseReason::missed:
      return "missed";
  }
  return "?";
}

/// One frame's result. The vectors keep their capacity from frame to frame.
struct PoseResult {
  SE3 T_w_c;  ///< camera to world; the world is the first frame's camera. Always finite, R orthonormal
  Quality quality = Quality::coasting;
  PoseReason reason = PoseReason::none;
  std::int64_t reference_frame = -1;  ///< index of the frame that it was matched against; -1 if none
  double step_m = 0;                  ///< |translation| since the reference frame, in the unit of the scale's source

  /// Of T_w_c, for T_w_c exp(xi) with xi = (x y z rx ry rz) in the camera's frame; 0 at frame 0, growing from there.
  /// In the map's unit: that the unit itself is uncertain is not in it. Only of estimators that say has_covariance.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  bool has_covariance = false;

  /// How the camera is held over the ground, where the estimator measures steps against it and has seen it.
  std::optional<GroundAttitude> attitude;

  int keypoints = 0;          ///< of this frame, those on people included
  int dropped_on_people = 0;  ///< of these, left out because they lie on people
  int matches = 0;            ///< = pairs.size()
  int inliers = 0;            ///< of these, the ones that the estimated motion explains

  PointPairs pairs;                     ///< the matches' pixels in the reference frame and in this one (sub-pixel)
  std::vector<std::uint8_t> is_inlier;  ///< one per pair, 0 or 1
  std::vector<std::uint8_t> kept;       ///< one per keypoint of this frame: 0 where it lies on a person, else 1

  /// A new frame, of which nothing is known yet: it coasts at `pose`. Keeps the vectors' memory.
  void begin(const SE3& pose) {
    T_w_c = pose;
    quality = Quality::coasting;
    reason = PoseReason::none;
    reference_frame = -1;
    step_m = 0;
    attitude.reset();
    keypoints = dropped_on_people = matches = inliers = 0;
    pairs.clear();
    is_inlier.clear();
    kept.clear();
  }
};

}  // namespace pavo
