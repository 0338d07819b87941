// The keyframe estimator without the engine: features, odometry and map called one behind the other, for measurements
// and tests that look into it. What the map made of a frame comes back as late as the engine's replay brings it.
//
//   PlainLoop loop(camera, {}, std::make_shared<UnknownStep>());
//   for (...) use(loop({.index = k, .t_ns = t}, image, people).T_w_c);
#pragma once

#include <array>
#include <cstddef>
#include <memory>

#include "stages/features/extract.h"
#include "stages/keyframe/keyframe_odometry.h"
#include "stages/map/metric_map.h"

namespace pavo {

struct PlainLoopOptions {
  FeatureOptions features{.max_features = 2000};
  KeyframeOdometryOptions odometry;
  MetricMapOptions map;
  bool with_map = true;  ///< false: what the map says is thrown away
};

/// One caller at a time; never blocks; allocates only to grow.
class PlainLoop {
 public:
  /// `rectified`: the camera of the images.
  PlainLoop(const Camera& rectified, const PlainLoopOptions& options, std::shared_ptr<const StepLength> step_length);

  /// The next frame. The result is valid until the next call.
  const PoseResult& operator()(const FrameTime& now, const Image& image, const People& people);
  /// A frame that failed before it came here.
  const PoseResult& missed(const FrameTime& now);

  const KeyframeRecord& record() const { return record_; }
  const Features& features() const { return slots_[current_].features; }
  const KeyframeOdometry& odometry() const { return odometry_; }
  const MetricMap& map() const { return map_; }
  /// CPU time of this thread that the last frame took, ms.
  double odometry_ms() const { return odometry_ms_; }
  double map_ms() const { return map_ms_; }

 private:
  static constexpr std::size_t kDelay = 2;
  struct Slot {
    Image image;
    Features features;
    bool there = false;
  };

  const MapUpdate* update_to_read() const;
  void run_map(const Image& image, const People& people);

  PlainLoopOptions options_;
  ExtractFeatures extract_;
  ExtractFeatures::Scratch scratch_;
  KeyframeOdometry odometry_;
  MetricMap map_;
  std::array<Slot, 2> slots_;
  std::array<MapUpdate, kDelay + 1> updates_;
  std::size_t frames_ = 0, current_ = 0;
  KeyframeRecord record_;
  PoseResult pose_;
  double odometry_ms_ = 0, map_ms_ = 0;
};

}  // namespace pavo
