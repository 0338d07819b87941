// How good matches are: against the true motion, and by the motion that is estimated from them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/detectors/frame_pairs.h"
#include "stages/matches/matches.h"
#include "stages/pose/relative_motion.h"

namespace pavo::bench {

/// A match is right when its current point is this near to the true epipolar line of its previous one.
inline constexpr double kRightPx = 1.5;

/// One flag per pair. Moving people and cars are wrong, whoever matched them; a wrong match along the line is right.
std::vector<std::uint8_t> right_ones(const PointPairs& pairs, const Camera& camera, const SE3& T_c_p);

struct MotionError {
  bool found = false;
  double rotation_deg = 0, direction_deg = 0;  ///< angles between the estimated and the true R, and t
};

/// Of pavo's RANSAC over the eight-point algorithm, with its refinement.
MotionError motion_error(const PointPairs& pairs, const Camera& camera, const FramePair& truth);

/// The value that `share` of them do not exceed, rounded up; 0 of none.
double quantile(std::vector<double> values, double share);
inline double median(const std::vector<double>& values) {
  return quantile(values, 0.5);
}

}  // namespace pavo::bench
