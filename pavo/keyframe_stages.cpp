#include "pavo/keyframe_stages.h"

#include <cstring>

#include "pavo/people_scan.h"

namespace pavo {

GroundScaleOptions ground_scale_options(const Config& config) {
  GroundScaleOptions options;
  options.filter.height_m = config.camera.height_m;
  options.filter.attitude.pitch_rad = config.camera.pitch_rad;
  return options;
}

KeyframeOdometryOptions keyframe_options(const Config& config) {
  KeyframeOdometryOptions options;
  options.seed = config.odometry.seed;
  options.match_ratio = static_cast<float>(config.odometry.match_ratio);
  options.people_mask = people_mask_options(config);
  options.motion.min_matches = config.odometry.min_matches;
  if (scale_from_camera_height(config)) options.systematic.log_scale = kToldHeightLogSigma;
  return options;
}

MetricMapOptions map_options(const Config& config) {
  MetricMapOptions options;
  options.map.refine_lens = config.odometry.refine_calibration;
  if (scale_from_camera_height(config)) options.ground = ground_scale_options(config);
  return options;
}

bool MapStage::take(const KeyframeRecord& keyframe, const Image& image, const People& people, Work& work) const {
  if (!keyframe.is_keyframe && !(keyframe.followed && map.needs_image())) return false;
  work.keyframe = keyframe;
  work.people.assign(people.begin(), people.end());
  if (!map.needs_image()) return true;
  work.image.resize(image.width(), image.height());
  for (int y = 0; y < image.height(); ++y)
    std::memcpy(work.image.row(y), image.row(y), static_cast<std::size_t>(image.width()));
  return true;
}

}  // namespace pavo
