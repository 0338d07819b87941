// What odometry and map tell each other: a keyframe on the way there, a map update on the way back.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "stages/ground/ground_plane.h"
#include "stages/map/ray_point.h"

namespace pavo {

using PointId = std::uint32_t;

struct KeyframePose {
  std::int64_t frame = -1;
  SE3 T_w_c;
};

/// One frame as the map wants it. The vectors keep their capacity.
struct KeyframeRecord {
  struct Observation {
    PointId point = 0;
    float x = 0, y = 0;     ///< pixel
    float sigma_px = 0.5f;  ///< of it
  };
  /// A point that the map does not know yet, in the frame of this keyframe's camera (identity pose).
  struct NewPoint {
    PointId point = 0;
    RayPoint in_keyframe;
  };

  bool is_keyframe = false;  ///< false: only a look at the ground, where followed
  bool followed = false;     ///< its pose is one in the map: T_last_c holds (keyframes: always)
  bool restart = false;      ///< the first keyframe of a new map: what was there is forgotten
  std::int64_t frame = -1;
  SE3 T_w_c;        ///< as odometry published it
  SE3 T_last_c;     ///< in the frame of the keyframe before (restart: T_w_c)
  double unit = 1;  ///< of all lengths here: MapUpdate::unit as the odometry had taken it over
  /// The true length of T_last_c.t and the standard deviation of its logarithm; sigma <= 0: not known.
  double baseline_m = 0, baseline_log_sigma = -1;
  std::vector<Observation> observations;
  std::vector<Observation> in_last_keyframe;  ///< of new points, where the keyframe before had seen them already
  std::vector<NewPoint> new_points;
  /// The keyframes before that the map may not have told of yet, as the odometry has them now, the oldest first.
  /// T_last_c is from the last of them; where the map did not get that one (live, a keyframe may be skipped), from
  /// another.
  std::vector<KeyframePose> before;
  /// Not for the map but for who wants to know: the keyframes that it adjusted last, where the odometry took that over.
  std::vector<KeyframePose> adjusted;

  /// So that one of so many points allocates nothing.
  void reserve(std::size_t points, std::size_t keyframes) {
    observations.reserve(points);
    in_last_keyframe.reserve(points);
    new_points.reserve(points);
    before.reserve(keyframes);
    adjusted.reserve(keyframes);
  }
  void clear() {
    is_keyframe = followed = restart = false;
    frame = -1;
    unit = 1;
    baseline_m = 0, baseline_log_sigma = -1;
    observations.clear();
    in_last_keyframe.clear();
    new_points.clear();
    before.clear();
    adjusted.clear();
  }
};

/// What the map made of a keyframe. The vectors keep their capacity.
struct MapUpdate {
  struct Point {
    PointId point = 0;
    RayPoint ray;      ///< world frame
    bool good = true;  ///< false: it does not stand still, or was never the same point: drop it
  };
  bool valid = false;
  std::int64_t frame = -1;  ///< of the keyframe
  SE3 T_w_c;                ///< of the keyframe, adjusted
  double unit = 1;          ///< of all lengths, by that of the first map: what was made since and is not listed
                            ///< here is to be scaled by how much it has grown
  LensError lens = LensError::Zero();  ///< what the calibration is off by, as it is known now
  /// Variance of the logarithm of the scale's error (negative: no more is known than before), and all that ever came to
  /// it anew.
  double scale_variance = -1, scale_walk = 0;
  /// m of the plane below the camera (ground_plane.h), in the camera's frame and this update's lengths, where it was
  /// seen.
  std::optional<Eigen::Vector3d> ground;
  std::vector<Point> points;
  std::vector<KeyframePose> window;  ///< all that were adjusted, the oldest first

  void clear() {
    window.clear();
    valid = false;
    frame = -1;
    unit = 1;
    scale_variance = -1, scale_walk = 0;
    ground.reset();
    points.clear();
  }
};

}  // namespace pavo
