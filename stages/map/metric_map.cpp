#include "stages/map/metric_map.h"

#include <cmath>

namespace pavo {
MetricMap::MetricMap(const Camera& camera, const MetricMapOptions& options)
    : options_(options), map_(camera, options.map) {
  if (options.ground) ground_.emplace(camera, *options.ground);
}

bool MetricMap::operator()(const KeyframeRecord& frame, const Image& image, const People& people, MapUpdate& update) {
  const bool anew = frame.is_keyframe && !map_.in_newest(frame);
  if (anew) unit_ = frame.unit;
  const double unit = unit_ / frame.unit;  // the odometry has not heard yet of what was made of the last frames
  if (!frame.is_keyframe) {
    if (ground_) look_between_keyframes(frame, image, people, unit);
    return false;
  }
  const bool has_baseline = map_.is_next(frame) && frame.baseline_log_sigma > 0;
  map_.add(frame, unit);
  if (anew && !ground_) variance_ = 1;
  const double factor = ground_ ? metres_by_ground(frame, image, people, anew) : metres_by_sensor(frame, has_baseline);
  apply_scale(ground_ ? ground_->known() : has_baseline, factor, update);
  return true;
}

// The way until here was measured with the scale that turns out to be wrong, and stays as it was published: the map is
// scaled about its newest keyframe, so that the path does not jump.
void MetricMap::apply_scale(bool sensed, double factor, MapUpdate& update) {
  const double variance = ground_ ? ground_->sigma() * ground_->sigma() : variance_;
  if (!ground_) walk_ += options_.scale_walk * options_.scale_walk;
  if (factor != 1) map_.rescale(factor);
  unit_ *= factor;
  map_.report(update);
  update.unit = unit_;
  update.scale_variance = sensed ? variance : -1;
  update.scale_walk = walk_;
  if (ground_ && ground_->known()) update.ground = down_of(ground_->attitude()) / options_.ground->filter.height_m;
}

void MetricMap::look_between_keyframes(const KeyframeRecord& frame, const Image& image, const People& people,
                                       double unit) {
  constexpr double kWorthALook = 0.25;  // of the way between keyframes
  const std::optional<SE3> in_newest = map_.in_newest(frame);
  if (!in_newest) return;
  const SE3 T = map_.newest_pose() * SE3{in_newest->R, unit * in_newest->t};
  if ((T.t - looked_from_.t).norm() < kWorthALook * map_.newest_baseline()) return;
  look_at_ground(frame.frame, image, T, people);
}

void MetricMap::look_at_ground(std::int64_t frame, const Image& image, const SE3& T_map_camera, const People& people) {
  const bool known = ground_->known();
  if (known) walk_ += options_.ground->scale_walk * options_.ground->scale_walk;
  look_ = ground_->observe(frame, image.view(), T_map_camera, people);
  looked_from_ = T_map_camera;
  // Lost: what the map has is still a better guess than a search from nothing.
  if (known && !ground_->known()) ground_->filter().assume(1, 0.25);
}

// The map is in metres from when the ground was seen first: what the filter says since is the correction that is left.
double MetricMap::metres_by_ground(const KeyframeRecord& keyframe, const Image& image, const People& people,
                                   bool anew) {
  if (anew) {
    // What the motion model knows of the scale is better than nothing, until the ground is seen again.
    const bool was_known = ground_->known();
    ground_->restart();
    if (was_known) ground_->filter().assume(1, 0.1);
  }
  look_at_ground(keyframe.frame, image, map_.newest_pose(), people);
  if (!ground_->known()) return 1;
  const double factor = ground_->metres_per_unit();
  ground_->rescale(factor, map_.newest_pose().t);
  return factor;
}

// A Kalman filter of one number: the logarithm of the length that the map should have had.
double MetricMap::metres_by_sensor(const KeyframeRecord& keyframe, bool has_baseline) {
  variance_ += options_.scale_walk * options_.scale_walk;
  const double length = map_.newest_baseline();
  if (!has_baseline || length < 1e-9 || keyframe.baseline_m < 1e-9) return 1;
  const double noise = keyframe.baseline_log_sigma * keyframe.baseline_log_sigma;
  const double gain = variance_ / (variance_ + noise);
  variance_ *= 1 - gain;
  return std::exp(gain * std::log(keyframe.baseline_m / length));
}

}  // namespace pavo
