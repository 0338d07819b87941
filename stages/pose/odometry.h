// Frame-to-frame odometry: the classic chain, from the features of two frames to the camera's pose.
//
//   drop the features on people -> match (nearest in SURF space, or KLT) -> sub-pixel -> stands still? -> RANSAC over
//   the normalised eight-point -> F to E -> the one of four motions with the points in front -> scale -> chain
//
// (Scaramuzza and Fraundorfer, "Visual Odometry, Part I", RAM 2011.)
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "stages/features/features.h"
#include "stages/ground/ground_scale.h"
#include "stages/people/people.h"
#include "stages/people/people_mask.h"
#include "stages/pose/motion_model.h"
#include "stages/pose/pose_result.h"
#include "stages/pose/put_back.h"
#include "stages/pose/relative_motion.h"
#include "stages/pose/scale.h"
#include "types/camera.h"
#include "types/image.h"
#include "types/spread.h"

namespace pavo {

enum class Tracker : std::uint8_t {
  descriptor,  ///< mutual nearest neighbours of the descriptors
  klt,         ///< optical flow from the previous frame's keypoints; needs both images
};

struct OdometryOptions {
  Tracker tracker = Tracker::descriptor;
  std::uint64_t seed = 0;       ///< of the run; each frame draws from a stream of its own
  float match_ratio = 0.85f;    ///< nearest over second nearest distance (Lowe's test)
  bool refine_subpixel = true;  ///< align the matches' patches, where the images are given (descriptor matcher)
  int max_reference_age = 10;   ///< frames that the last good frame is kept for, to be matched against
  PeopleMaskOptions people_mask;
  bool put_back = true;  ///< matches on "people" who move with the street are used (descriptor matcher)
  PutBackOptions street;
  std::optional<GroundScaleOptions> ground;  ///< steps are measured against the ground; needs the images
  RelativeMotionOptions motion;
  Spread* spread = nullptr;  ///< who helps with the matching; null: nobody. Must outlive the stage
};

/// What is known of one frame; it stays where it is (the frame's slot). `image` is needed by KLT and makes descriptor
/// matches sub-pixel; without it they stay where FAST saw them. features == nullptr: no such frame.
struct FrameView {
  const Features* features = nullptr;
  const Image* image = nullptr;
};

/// The in-order stage. Called once per frame, in order, by one thread at a time; never blocks. With the descriptor
/// matcher nothing is allocated once the largest frame has been seen (KLT: what OpenCV allocates in it).
/// Two of them, one without people, compare geometry alone with pavo; they match separately.
class Odometry {
 public:
  /// `camera` is the rectified one (its lens is not looked at). Throws std::runtime_error where it is not finite or
  /// not positive.
  Odometry(const Camera& camera, const OdometryOptions& options, std::shared_ptr<const StepLength> step_length);
  ~Odometry();
  Odometry(Odometry&&) noexcept;
  Odometry& operator=(Odometry&&) noexcept;

  /// A frame that is there. `previous` is the frame of the call before, if that was not missed(); what it was told
  /// about people is remembered.
  void operator()(const FrameTime& now, const FrameView& current, const FrameView& previous, const People& people,
                  PoseResult& out);

  /// A frame that failed: the motion model's pose. The last good frame is copied, so that the next one can be matched
  /// against it when its slot is gone; `previous` as above.
  void missed(const FrameTime& now, const FrameView& previous, PoseResult& out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace pavo
