// False alarms of the detector put right by geometry: a "person" who moves as the street does is none, or stands there,
// and the matches on them are as good as any.
#pragma once

#include <span>

#include "stages/matches/matches.h"
#include "stages/people/people.h"
#include "stages/people/people_mask.h"
#include "types/camera.h"
#include "types/pose.h"

namespace pavo {

struct PutBackOptions {
  float believed = 0.5f;         ///< who is a person with this probability is one, and is not asked
  double threshold_px = 1;       ///< largest Sampson distance of a match that moves with the street
  double least_parallax_px = 2;  ///< and what it has to move beyond the camera's rotation: see below
  int least_matches = 4;         ///< with the street, in one outline; fewer decide nothing
  double least_share = 0.8;      ///< of the matches in an outline that say anything
};

/// T_c_p is the camera's motion (points of the previous camera into the current one, |t| = 1), found without anybody.
/// A match moves *with* the street if it fits T_c_p, has parallax and lies in front of both cameras; *against* it if it
/// does not fit. One that fits without parallax says nothing: so does what is far away, but so do people who walk along
/// with the camera on a straight road: their place in the picture stays. An outline is the street's where nearly all
/// matches that say anything are with it. One match alone would not do: in a turn those on a companion's hips move
/// along epipolar lines by chance, those on the head and the feet do not.
///
/// A match that is in nobody's outline any more, because its box has moved on or gone, is judged alone.
///
/// Appends to `street` the matches with the street that lie, in the current frame, in outlines of the street only; of
/// one that overlaps a person's, what lies on the person stays out. Pure; allocates only to grow `street`.
void put_back(std::span<const PointPair> on_people, const People& people, const PeopleMaskOptions& mask,
              const Camera& camera, const SE3& T_c_p, const PutBackOptions& options, PointPairs& street);

}  // namespace pavo
