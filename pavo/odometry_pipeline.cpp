#include "pavo/odometry_pipeline.h"

#include <opencv2/core/utility.hpp>
#include <optional>

#include "pavo/engine_options.h"
#include "pavo/horizon_stage.h"
#include "pavo/keyframe_stages.h"
#include "pavo/late_scan.h"
#include "pavo/people_scan.h"
#include "pavo/workers_spread.h"
#include "stages/decode/decode.h"
#include "stages/features/extract.h"
#include "stages/people/track_people.h"
#include "stages/pose/odometry.h"
#include "stages/undistort/undistort.h"

namespace pavo {
namespace {

// The odometry as the engine calls it, with people or without.
struct OdometryStage {
  Odometry odometry;

  void operator()(const FrameInfo& info, const Features& features, const Image& image, const People& people,
                  const Features* previous_features, const Image* previous_image, PoseResult& pose) {
    odometry(time_of(info), {&features, &image}, {previous_features, previous_image}, people, pose);
  }
  void operator()(const FrameInfo& info, const Features& features, const Image& image,
                  const Features* previous_features, const Image* previous_image, PoseResult& pose) {
    const People nobody;
    (*this)(info, features, image, nobody, previous_features, previous_image, pose);
  }
  void missed(const FrameInfo& info, const Features* previous_features, const Image* previous_image, PoseResult& pose) {
    odometry.missed(time_of(info), {previous_features, previous_image}, pose);
  }
};

OdometryOptions odometry_options(const Config& config, Spread* spread) {
  OdometryOptions options;
  options.spread = spread;
  options.tracker = config.odometry.tracker == "klt" ? Tracker::klt : Tracker::descriptor;
  options.seed = config.odometry.seed;
  options.match_ratio = static_cast<float>(config.odometry.match_ratio);
  options.people_mask = people_mask_options(config);
  options.put_back = config.people.put_back;
  options.motion.min_matches = config.odometry.min_matches;
  if (scale_from_camera_height(config)) options.ground = ground_scale_options(config);
  return options;
}

FeatureOptions feature_options(const Config& config) {
  FeatureOptions options;
  options.max_features = config.features.max_features;
  options.oriented = config.features.oriented;
  options.descriptors = config.odometry.tracker != "klt";
  return options;
}

}  // namespace

struct OdometryPipeline::Stages {
  Stages(Pipeline<Frame>& pipeline, int workers) : spread(pipeline, workers) {}
  WorkersSpread<Frame> spread;
  std::optional<Undistort> undistort;
  std::optional<TrackPeople> people;
  std::optional<HorizonStage> horizon;
  std::optional<OdometryStage> odometry;
  std::optional<OdometryStage> geometric;
  std::optional<KeyframeOdometryStage> keyframe, keyframe_geometric;
  std::optional<MapStage> map, map_geometric;
};

OdometryPipeline::~OdometryPipeline() = default;

OdometryPipeline::OdometryPipeline(const Config& config, const Camera& camera,
                                   std::shared_ptr<const StepLength> step_length, Input input, Clock& clock)
    : rectified_(camera),
      undistorted_(camera.lens != Lens::rectified || config.undistort.alpha > 0),
      pipeline_(std::make_unique<Pipeline<Frame>>(engine_options(config), clock)) {
  stages_ = std::make_unique<Stages>(*pipeline_, engine_options(config).workers);
  cv::setNumThreads(1);  // 0 would leave the pool that somebody made before, and the figure that it reports
  ImageView valid_mask;
  if (undistorted_) {
    stages_->undistort.emplace(camera, config.undistort.alpha);
    rectified_ = stages_->undistort->rectified_camera();
    valid_mask = stages_->undistort->valid_mask();
  }
  Pipeline<Frame>& p = *pipeline_;

  const auto unpacked = undistorted_ ? &Frame::raw : &Frame::image;
  if (input == Input::encoded) {
    p.source(writes(&Frame::encoded));
    p.add("decode", reads(&Frame::encoded), writes(unpacked), Decode(camera.width, camera.height), parallel);
  } else {
    p.source(writes(unpacked));
  }
  if (undistorted_)
    p.add("undistort", reads(&Frame::raw), writes(&Frame::image), std::cref(*stages_->undistort), parallel);

  p.add("features", reads(&Frame::image), writes(&Frame::features),
        ExtractFeatures(feature_options(config), camera.width, camera.height, valid_mask), parallel);

  if (config.people.enabled) {
    stages_->people.emplace();
    add_scan(config);
    p.add("people", reads(&Frame::detections, &Frame::scanned), writes(&Frame::people),
          TrackUnlessLate{*stages_->people}, in_order);
  }
  if (uses_keyframes(config))
    add_keyframe(config, std::move(step_length));
  else
    add_frame_to_frame(config, std::move(step_length));
}

// Where odometry sees the ground, it tells the scan how the camera is held over it.
void OdometryPipeline::add_scan(const Config& config) {
  Pipeline<Frame>& p = *pipeline_;
  const ScanUnlessLate scan{make_scan(config, rectified_, &stages_->spread), config.people.sizes_in_turn};
  if (!scale_from_camera_height(config)) {
    p.add("scan", reads(&Frame::image), writes(&Frame::detections, &Frame::scanned), scan, parallel);
    return;
  }
  stages_->horizon.emplace(config, rectified_);
  if (uses_keyframes(config)) {
    p.add("horizon", reads(delayed<kHorizonDelay>(&Frame::map)), writes(&Frame::standing), std::ref(*stages_->horizon),
          in_order);
  } else {
    p.add("horizon", reads(delayed<kHorizonDelay>(&Frame::attitude)), writes(&Frame::standing),
          std::ref(*stages_->horizon), in_order);
    p.add("attitude", reads(&Frame::pose), writes(&Frame::attitude), TellAttitude{}, background);
  }
  p.add("scan", reads(&Frame::image, &Frame::standing), writes(&Frame::detections, &Frame::scanned), scan, parallel);
}

void OdometryPipeline::add_frame_to_frame(const Config& config, std::shared_ptr<const StepLength> step_length) {
  Pipeline<Frame>& p = *pipeline_;
  stages_->odometry.emplace(
      OdometryStage{Odometry(rectified_, odometry_options(config, &stages_->spread), step_length)});
  if (config.people.enabled) {
    p.add("odometry",
          reads(&Frame::features, &Frame::image, &Frame::people, previous(&Frame::features), previous(&Frame::image)),
          writes(&Frame::pose), std::ref(*stages_->odometry), in_order);
  } else {
    p.add("odometry", reads(&Frame::features, &Frame::image, previous(&Frame::features), previous(&Frame::image)),
          writes(&Frame::pose), std::ref(*stages_->odometry), in_order);
  }
  if (config.odometry.compare) {
    stages_->geometric.emplace(
        OdometryStage{Odometry(rectified_, odometry_options(config, &stages_->spread), std::move(step_length))});
    p.add("geometric", reads(&Frame::features, &Frame::image, previous(&Frame::features), previous(&Frame::image)),
          writes(&Frame::geometric), std::ref(*stages_->geometric), in_order);
  }
}

void OdometryPipeline::add_keyframe(const Config& config, std::shared_ptr<const StepLength> step_length) {
  check_estimator(config);
  Pipeline<Frame>& p = *pipeline_;
  const KeyframeOdometryOptions options = keyframe_options(config);
  stages_->keyframe.emplace(KeyframeOdometryStage{KeyframeOdometry(rectified_, options, step_length)});
  stages_->map.emplace(MapStage{MetricMap(rectified_, map_options(config))});
  if (config.people.enabled) {
    p.add("odometry",
          reads(&Frame::features, &Frame::image, &Frame::people, previous(&Frame::features), previous(&Frame::image),
                delayed<kMapDelay>(&Frame::map)),
          writes(&Frame::pose, &Frame::keyframe), std::ref(*stages_->keyframe), in_order);
  } else {
    p.add("odometry",
          reads(&Frame::features, &Frame::image, previous(&Frame::features), previous(&Frame::image),
                delayed<kMapDelay>(&Frame::map)),
          writes(&Frame::pose, &Frame::keyframe), std::ref(*stages_->keyframe), in_order);
  }
  if (config.people.enabled)
    p.add("map", reads(&Frame::keyframe, &Frame::image, &Frame::people), writes(&Frame::map), std::ref(*stages_->map),
          background);
  else
    p.add("map", reads(&Frame::keyframe, &Frame::image), writes(&Frame::map), std::ref(*stages_->map), background);
  if (config.odometry.compare) {
    stages_->keyframe_geometric.emplace(KeyframeOdometryStage{KeyframeOdometry(rectified_, options, step_length)});
    stages_->map_geometric.emplace(MapStage{MetricMap(rectified_, map_options(config))});
    p.add("geometric",
          reads(&Frame::features, &Frame::image, previous(&Frame::features), previous(&Frame::image),
                delayed<kMapDelay>(&Frame::geometric_map)),
          writes(&Frame::geometric, &Frame::geometric_keyframe), std::ref(*stages_->keyframe_geometric), in_order);
    p.add("geometric map", reads(&Frame::geometric_keyframe, &Frame::image), writes(&Frame::geometric_map),
          std::ref(*stages_->map_geometric), background);
  }
}

}  // namespace pavo
