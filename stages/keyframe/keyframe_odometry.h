// Odometry on keyframes: points that live over many frames, the pose from all of them, the map adjusted behind it.
//
//   take over what the map found -> predict -> find points by descriptor near where they should be -> pose -> align
//   the patches of all points from there -> stands still? -> pose -> depths -> keyframe?
#pragma once

#include <cstdint>
#include <memory>

#include "stages/keyframe/pose_uncertainty.h"
#include "stages/keyframe/refine_pose.h"
#include "stages/map/map_messages.h"
#include "stages/matches/align_patch.h"
#include "stages/people/people.h"
#include "stages/people/people_mask.h"
#include "stages/pose/odometry.h"
#include "stages/pose/pose_result.h"
#include "stages/pose/relative_motion.h"
#include "stages/pose/scale.h"
#include "types/camera.h"

namespace pavo {

struct KeyframeOdometryOptions {
  std::uint64_t seed = 0;
  float match_ratio = 0.85f;
  PeopleMaskOptions people_mask;
  RelativeMotionOptions motion{.planes = true};  ///< of the start, and where points are not found as expected
  AlignOptions align;

  int max_points = 500;           ///< that are followed, spread over the picture
  int least_spacing_px = 12;      ///< of the cells for one point each, in pictures that are small for so many
  double search_px = 40;          ///< how far from where it is expected a point is looked for
  float max_distance2 = 0.25f;    ///< of descriptors, squared
  int max_coarse = 200;           ///< points that the pose is looked for with, before all are aligned
  double sigma_px = 0.4;          ///< of an aligned point
  double coarse_sigma_px = 1.0;   ///< of a keypoint
  double loss_scale = 1.5;        ///< of an aligned point's robust loss, in sigma_px
  double mature_px = 3;           ///< uncertainty of the predicted pixel up to which a point is looked for there alone
  double new_patch_ratio = 1.25;  ///< change of size from which on the patch is taken anew
  int max_misses = 4;
  int min_tracked = 20;            ///< fewer points than this are no pose
  int sure_tracked = 60;           ///< so many are a pose, however far from where it was expected
  double min_agreement = 0.4;      ///< share of the points that a pose has to explain
  int lost_after = 5;              ///< frames without a pose until the map is begun anew
  int lost_after_standing = 50;    ///< the same where the camera stood: a lorry that passes is not a new world
  double farthest_below = 2;       ///< distances of the ground: what is farther in its direction goes with the camera
  double sure_of_ground = 0.1;     ///< standard deviation of the logarithm of scale up to which the ground is believed
  double ground_slack_rad = 0.06;  ///< by so much the ground may fall ahead
  double keyframe_px = 25;         ///< median motion since the last keyframe that makes one
  double keyframe_share = 0.6;     ///< or fewer points than this share of the last keyframe's are left
  double start_parallax_px = 1.5;
  SystematicErrors systematic;
  double unknown_log_sigma = 1;  ///< of the logarithm of a length that nothing told
};

/// The in-order stage. As Odometry; what it hands to the map is `record`, what comes back from it `update`.
class KeyframeOdometry {
 public:
  KeyframeOdometry(const Camera& camera, const KeyframeOdometryOptions& options,
                   std::shared_ptr<const StepLength> step_length);
  ~KeyframeOdometry();
  KeyframeOdometry(KeyframeOdometry&&) noexcept;
  KeyframeOdometry& operator=(KeyframeOdometry&&) noexcept;

  /// `update`: what the map made of an earlier frame, or null.
  void operator()(const FrameTime& now, const FrameView& current, const FrameView& previous, const People& people,
                  const MapUpdate* update, PoseResult& out, KeyframeRecord& record);
  void missed(const FrameTime& now, const FrameView& previous, const MapUpdate* update, PoseResult& out,
              KeyframeRecord& record);

 private:
  struct Keyframe;
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace pavo
