// Where the scan looks for people's feet: by the camera's height and pitch as configured, and as odometry refines them.
#pragma once

#include <optional>

#include "pavo/people_scan.h"
#include "stages/ground/ground_plane.h"
#include "stages/map/map_messages.h"
#include "stages/people/standing_prior.h"
#include "stages/pose/pose_result.h"

namespace pavo {

/// Frames until what odometry saw of the ground is used by the scan: as many as keep two workers busy in between.
inline constexpr int kHorizonDelay = 4;

/// The in-order stage `horizon`. A parallel scan cannot remember the last pitch, this can: it holds until there is a
/// newer one.
class HorizonStage {
 public:
  HorizonStage(const Config& config, const Camera& camera)
      : config_(config), camera_(camera), prior_(standing_prior(config, camera)) {}

  void operator()(const GroundAttitude* seen, std::optional<StandingPrior>& standing) {
    if (seen) look(*seen);
    standing = prior_;
  }
  void operator()(const MapUpdate* update, std::optional<StandingPrior>& standing) {
    if (update && update->ground) look(attitude_of(*update->ground));
    standing = prior_;
  }
  template <class Seen>
  void missed(const Seen* seen, std::optional<StandingPrior>& standing) {
    (*this)(seen, standing);
  }

 private:
  void look(const GroundAttitude& seen) {
    config_.camera.pitch_rad = seen.pitch_rad;
    prior_ = standing_prior(config_, camera_);
  }

  Config config_;
  Camera camera_;
  std::optional<StandingPrior> prior_;
};

/// The background stage that sends what frame-to-frame saw of the ground on its way back; the keyframe estimator's is
/// in its map updates.
struct TellAttitude {
  struct Work {
    GroundAttitude attitude;
  };
  bool take(const PoseResult& pose, Work& work) const {
    if (pose.attitude) work.attitude = *pose.attitude;
    return pose.attitude.has_value();
  }
  void operator()(Work& work, GroundAttitude& attitude) const { attitude = work.attitude; }
};

}  // namespace pavo
