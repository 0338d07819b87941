// The stage `map`: the local map, in metres where something tells metres. It runs behind the odometry, which takes over
// what it says some frames later.
#pragma once

#include <optional>

#include "stages/ground/ground_scale.h"
#include "stages/map/local_map.h"
#include "stages/people/people.h"
#include "types/image.h"

namespace pavo {

struct MetricMapOptions {
  LocalMapOptions map;
  std::optional<GroundScaleOptions> ground;  ///< metres from the camera's height above the road
  double scale_walk = 0.01;  ///< of the map's log(scale) from keyframe to keyframe, where a sensor tells lengths
};

/// In order, one caller at a time; never blocks; allocates only to grow.
class MetricMap {
 public:
  MetricMap(const Camera& camera, const MetricMapOptions& options);

  /// A frame that was followed, its image and the people in it. True for a keyframe: the update is what the odometry is
  /// to take over. The others are only looked at for the ground's sake: in a crowd every bit of it counts.
  bool operator()(const KeyframeRecord& frame, const Image& image, const People& people, MapUpdate& update);

  /// Whether operator() looks at the image.
  bool needs_image() const { return ground_.has_value(); }
  const LensError& lens() const { return map_.lens(); }  ///< what the calibration is off by
  const GroundLook& last_look() const { return look_; }
  const GroundScale* ground() const { return ground_ ? &*ground_ : nullptr; }

 private:
  void look_between_keyframes(const KeyframeRecord& frame, const Image& image, const People& people, double unit);
  void look_at_ground(std::int64_t frame, const Image& image, const SE3& T_map_camera, const People& people);
  double metres_by_ground(const KeyframeRecord& keyframe, const Image& image, const People& people, bool anew);
  double metres_by_sensor(const KeyframeRecord& keyframe, bool has_baseline);
  void apply_scale(bool sensed, double factor, MapUpdate& update);

  MetricMapOptions options_;
  LocalMap map_;
  std::optional<GroundScale> ground_;
  GroundLook look_;
  SE3 looked_from_;
  double unit_ = 1;      ///< the product of all factors by which the map was scaled
  double variance_ = 1;  ///< of the map's log(scale), by the sensor's filter
  double walk_ = 0;      ///< all that ever came to it anew
};

}  // namespace pavo
