// Does the camera stand still? Asked before anything is estimated: without motion there is no epipolar geometry,
// and an essential matrix of noise looks like any other.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "stages/matches/matches.h"
#include "types/camera.h"

namespace pavo {

/// The limits suit matches that are sub-pixel (about 0.1 px). Measured with those: at rest, 60 % of the matches are
/// within 0.13 px of a small rotation; at 5 cm a frame in a street half of them are beyond 0.6 px, at 2 cm beyond 0.24.
struct StandstillOptions {
  double max_motion_px = 2.5;     ///< what wind, an engine or a hand may shake the picture, and it still is at rest
  double max_residual_px = 0.25;  ///< of a match at rest, beside the rotation that the shaking is
  double min_share = 0.5;         ///< of the picture that has to be at rest. What moves beside it are people and cars
  int min_matches = 20;           ///< fewer prove nothing
};

/// True where pairs that stand for at least min_share of the picture moved less than max_motion_px, and all as one
/// small rotation does it: no parallax, so no translation, and a rotation that is not worth telling. Pairs in one cell
/// of a 16 x 8 grid share what that cell counts for: a car ahead may have more corners than the street. Marks the pairs
/// at rest in `at_rest` (resized to one flag per pair; all 0 when false). Allocates only to grow `at_rest`; O(n), and
/// most moving frames are told from the first condition alone.
bool stands_still(std::span<const PointPair> pairs, const Camera& camera, const StandstillOptions& options,
                  std::vector<std::uint8_t>& at_rest);

/// The small rotation (vector, rad; of points, previous to current camera) that explains most of the pairs, by
/// reweighted least squares with Geman and McClure's loss. For motions of a few pixels only: linear in the angle.
Eigen::Vector3d small_rotation(std::span<const PointPair> pairs, const Camera& camera);

}  // namespace pavo
