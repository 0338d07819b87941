// What the odometry remembers from frame to frame. Private to stages/keyframe: its parts are in start_map.cpp (the
// first points), follow_points.cpp (where they are now), keep_points.cpp (what they say, and which new ones there are),
// tell_uncertainty.cpp (how sure that is).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <vector>

#include "stages/keyframe/carried_along.h"
#include "stages/keyframe/keyframe_odometry.h"
#include "stages/keyframe/keypoint_search.h"
#include "stages/keyframe/point_grid.h"
#include "stages/keyframe/pose_uncertainty.h"
#include "stages/keyframe/refine_pose.h"
#include "stages/keyframe/tracked_point.h"
#include "stages/matches/nearest.h"
#include "stages/matches/refine_subpixel.h"

namespace pavo {

/// A keyframe that the map may still say something about.
struct KeyframeOdometry::Keyframe {
  FrameTime time;
  SE3 T_w_c;
};

struct KeyframeOdometry::State {
  State(const Camera& rectified, const KeyframeOdometryOptions& how, std::shared_ptr<const StepLength> length)
      : calibrated(rectified),
        camera(rectified),
        options(how),
        step_length(std::move(length)),
        match_nearest({.ratio = how.match_ratio}),
        relative_motion(rectified, how.motion),
        uncertainty(how.systematic, rectified.fx),
        points(static_cast<std::size_t>(how.max_points) * 2),
        carried(rectified.width, rectified.height),
        grid(rectified.width, rectified.height, how.max_points, how.least_spacing_px) {
    if (!step_length) throw std::invalid_argument("odometry: no step length given");
    // What holds a part of the points: how large a part differs from frame to frame, and no frame shall allocate.
    for (auto* of_points : {&constrained, &candidates}) of_points->reserve(points.size());
    constraints.reserve(points.size());
    reference_image.resize(rectified.width, rectified.height);  // new memory costs the first frame more than the copy
    by_id.reserve(points.size());
    pairs.reserve(points.size());
    scratch.reserve(points.size());
    at_rest.reserve(points.size());
  }

  // What happens in a frame, in order.
  void begin(const FrameTime& now, PoseResult& out, KeyframeRecord& record);
  void take_over(const MapUpdate& update);
  void drop_features_on_people(const Features& features, const People& people, PoseResult& out);
  bool follow(const FrameTime& now, const FrameView& current, const FrameView& previous, const People& people,
              PoseResult& out, KeyframeRecord& record);
  void coast(const FrameTime& now, PoseResult& out);
  void end(const FrameTime& now, bool estimated, PoseResult& out);

  // The start of a map.
  void set_reference(const FrameTime& now, const FrameView& current, const PoseResult& out, KeyframeRecord& record);
  bool start(const FrameTime& now, const FrameView& current, PoseResult& out, KeyframeRecord& record);
  void thin_matches(const Features& now);
  void make_first_points(const FrameView& current, const SE3& T_w_c, PoseResult& out, KeyframeRecord& record);

  // Following points.
  PosePrior expected(const FrameTime& now) const;
  int find_keypoints(const SE3& T, const Features& features, double radius_px, int every, int first);
  bool find_pose(const FrameTime& now, const FrameView& current, const FrameView& previous, const PosePrior& prior,
                 SE3& T, PoseResult& out);
  bool recover(const FrameTime& now, const FrameView& current, const FrameView& previous, SE3& T, PoseResult& out);
  void align_points(const SE3& T, const FrameView& current, const People& people);
  bool align_point(TrackedPoint& point, const Image& image, const Eigen::Vector2d& expected_px, double patch_scale,
                   double max_shift_px);
  void align_along_line(TrackedPoint& point, const SE3& T, const FrameView& current);
  bool standing(PoseResult& out);

  // How sure that is.
  double pixel_variance(double median_chi2);
  void tell_uncertainty(const RefinedPose& pose);
  void begin_scale(bool told);
  void tell_uncertainty_of_start(const SE3& T_r_c, const PoseResult& out);
  void guess_uncertainty(const PoseResult& out);
  RefinedPose pose_of_found(const PosePrior& prior, const SE3& start);
  double points_needed(const PosePrior& prior, const SE3& T) const;
  void update_points(const SE3& T, const FrameView& current);
  void update_depth(TrackedPoint& point, const SE3& T) const;
  bool is_below_ground(const RayPoint& ray, const SE3& T) const;
  bool wants_keyframe() const;
  void make_keyframe(const FrameTime& now, const FrameView& current, const SE3& T, KeyframeRecord& record,
                     const PoseResult& out);
  void add_points(const FrameView& current, const SE3& T, KeyframeRecord& record, const PoseResult& out);
  TrackedPoint* free_point();
  void report(PoseResult& out);

  Camera calibrated;
  Camera camera;  // as the map knows it by now
  KeyframeOdometryOptions options;
  std::shared_ptr<const StepLength> step_length;
  MatchNearest match_nearest;
  RefineSubpixel refine_subpixel;
  RelativeMotionEstimator relative_motion;
  MotionModel motion_model;
  KeypointSearch search;

  bool started = false, has_reference = false, has_map = false, has_scale = false, scale_known = false;
  bool stood = false;  // in the last frame with a pose
  FrameTime last_time;
  SE3 last_T;                             // in the map as it is now
  SE3 published_T;                        // as it was published
  bool stays = false;                     // this frame is where the last one is: last_T goes on being the map's
  double unit = 1;                        // of the map as it was taken over last
  std::optional<Eigen::Vector3d> ground;  // m of the plane below the camera, in the map's lengths
  std::vector<std::uint8_t> last_kept;
  int lost = 0;
  PoseUncertainty uncertainty;
  double noise_ratio = 0;  ///< of the points' residuals to what options.sigma_px says, squared; 0: not known yet

  // The reference of a start.
  FrameTime reference_time, reference_still;
  SE3 reference_T;
  Features reference_features;
  Image reference_image;
  std::vector<std::uint8_t> reference_kept;
  int reference_matches = 0;

  std::vector<TrackedPoint> points;
  CarriedAlong carried;
  PointGrid grid;
  PointId next_id = 1;
  std::vector<Keyframe> keyframes;  // whose updates may still come
  double median_rho = 0.05, high_rho = 0.3;

  Matches matches;
  MatchNearest::Scratch nearest_scratch;
  std::vector<std::uint8_t> refined, at_rest;
  PoseConstraints constraints;
  std::vector<int> constrained;
  std::vector<FoundKeypoint> keypoint_of;
  std::vector<std::pair<PointId, TrackedPoint*>> by_id;
  std::vector<float> scratch;
  PointPairs pairs;
  std::vector<int> candidates;
  int tracked_at_keyframe = 0;
};

}  // namespace pavo
