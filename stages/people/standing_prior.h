// Where the ground is in the picture, and which windows of the scan can hold somebody who stands on it.
#pragma once

#include "stages/people/people.h"
#include "stages/people/pyramid.h"

namespace pavo {

/// A flat ground before a camera that does not roll. With the horizon at row v0, a person of h metres whose feet are
/// seen at row v is
///
///     (v - v0) h / camera_height
///
/// px high, whatever the focal length and the distance (Hoiem, Efros and Hebert, Putting Objects in Perspective, CVPR
/// 2006).
struct StandingPrior {
  double horizon_px = 0;       ///< row of the image
  double camera_height_m = 0;  ///< over the ground, > 0
  double slack_px = 0;         ///< the feet may be so much higher or lower: ground that rises or falls, the pitch of a
                               ///< camera on its springs, a box that is not exact
  double least_m = 1.2;        ///< height of a person
  double most_m = 2.1;

  bool operator==(const StandingPrior&) const = default;
};

/// Throws std::invalid_argument if something is out of its range.
void check(const StandingPrior& ground);

/// Rows of windows [begin, end) of one level; none where begin >= end.
struct WindowRows {
  int begin = 0, end = 0;
};

/// Those in whose windows a person would stand on the ground.
WindowRows rows_on_ground(const StandingPrior& ground, const hog::Level& level);

/// Whether the person of this box can stand on the ground.
bool stands_on_ground(const StandingPrior& ground, const PersonBox& person);

/// Drops who cannot; the order stays. Allocates nothing.
void keep_who_stands(const StandingPrior& ground, Detections& people);

}  // namespace pavo
