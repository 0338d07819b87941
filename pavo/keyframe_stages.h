// The keyframe estimator as the engine calls it: `odometry` in the frame's way, `map` behind it.
#pragma once

#include <memory>

#include "engine/frame_info.h"
#include "pavo/config.h"
#include "stages/keyframe/keyframe_odometry.h"
#include "stages/map/metric_map.h"
#include "stages/people/people.h"

namespace pavo {

/// What a height that was told, or measured with a folding rule, is to be trusted to; the road's, under the wheels.
inline constexpr double kToldHeightLogSigma = 0.004;

/// Frames until what the map made of a keyframe is read by the odometry.
inline constexpr int kMapDelay = 2;

inline FrameTime time_of(const FrameInfo& info) {
  return {.index = info.source_index, .t_ns = info.t_capture_ns, .lost_before = static_cast<std::int64_t>(info.gap)};
}

struct KeyframeOdometryStage {
  KeyframeOdometry odometry;

  void operator()(const FrameInfo& info, const Features& features, const Image& image, const People& people,
                  const Features* previous_features, const Image* previous_image, const MapUpdate* map,
                  PoseResult& pose, KeyframeRecord& record) {
    odometry(time_of(info), {&features, &image}, {previous_features, previous_image}, people, map, pose, record);
  }
  void operator()(const FrameInfo& info, const Features& features, const Image& image,
                  const Features* previous_features, const Image* previous_image, const MapUpdate* map,
                  PoseResult& pose, KeyframeRecord& record) {
    const People nobody;
    (*this)(info, features, image, nobody, previous_features, previous_image, map, pose, record);
  }
  void missed(const FrameInfo& info, const Features* previous_features, const Image* previous_image,
              const MapUpdate* map, PoseResult& pose, KeyframeRecord& record) {
    odometry.missed(time_of(info), {previous_features, previous_image}, map, pose, record);
  }
};

struct MapStage {
  struct Work {
    Work() {  // keyframes are rare: the largest may come late
      keyframe.reserve(2 * static_cast<std::size_t>(KeyframeOdometryOptions().max_points), 32);
      people.reserve(64);
    }
    KeyframeRecord keyframe;
    Image image;  ///< where the map looks at it
    People people;
  };
  MetricMap map;

  bool take(const KeyframeRecord& keyframe, const Image& image, const People& people, Work& work) const;
  bool take(const KeyframeRecord& keyframe, const Image& image, Work& work) const {
    const People nobody;
    return take(keyframe, image, nobody, work);
  }
  bool operator()(Work& work, MapUpdate& update) { return map(work.keyframe, work.image, work.people, update); }
};

/// Where the camera is over the ground, for whatever measures metres by it.
GroundScaleOptions ground_scale_options(const Config& config);
KeyframeOdometryOptions keyframe_options(const Config& config);
MetricMapOptions map_options(const Config& config);

}  // namespace pavo
