// How far off the pose may be, from frame to frame: drift that stays, the frame's own noise that does not, the scale.
#pragma once

#include "stages/map/map_messages.h"
#include "stages/map/scale_error.h"
#include "stages/map/se3_step.h"

namespace pavo {

/// What is the same for the whole drive, so that it grows with the way. Standard deviations.
struct SystematicErrors {
  double log_scale = 0;           ///< of all lengths: a told height that is wrong
  double turn_px_per_m = 1.5e-3;  ///< a camera that is not quite as its calibration says turns with every metre
  double pitch_px_per_m = 4e-3;   ///< it drifts in pitch more, and always to one side (docs/odometry.md)
  double direction_px = 0.04;     ///< of where in the picture the direction of its way is
};

/// Four parts, all for T_w_c exp(xi), xi = (x y z rx ry rz) in the camera's frame:
///
/// - Drift. A point's own error (its patch was cut out of one noisy image, at one wrong place) is in every frame that
///   sees it, and leaves with it: it does not average out over frames, only over points. So what a frame's points say
///   about the pose, the inverse of the normal equations' matrix M, is added once for each generation of points,
///   M / life per frame, and carried along by the camera's motion.
/// - Noise of this frame alone: M. The next frame is compared with the map, not with this frame: it is not handed on.
/// - The scale's error, correlated from frame to frame (ScaleError).
/// - SystematicErrors, fully correlated.
class PoseUncertainty {
 public:
  PoseUncertainty(const SystematicErrors& systematic, double focal_px);

  /// From the pose before to this one, which the map told; `drift` (in this camera's frame) stays, `noise` is of this
  /// frame only.
  void step(const SE3& from, const SE3& to, const Matrix6d& drift, const Matrix6d& noise);
  /// From the pose before to a guess: what is wrong with it lasts until the map is found again.
  void coast(const SE3& from, const SE3& to, const Matrix6d& guess);
  /// What is not known of this pose will stay so: a map begins here.
  void begin_map();
  /// A map begins, in a unit whose logarithm has this standard deviation.
  void begin_scale(double log_sigma) { scale_.restart(log_sigma * log_sigma); }
  /// What the map found out; the pose is moved by that, and all lengths are `scale` times what they were.
  void take_over(const MapUpdate& update, double scale);

  /// Of the pose that step() or coast() came to.
  Matrix6d covariance(const SE3& T_w_c) const;

 private:
  void carry(const SE3& from, const SE3& to);

  SystematicErrors systematic_;
  Vector6d per_m_;  ///< standard deviation of what every metre adds to xi
  Matrix6d drift_ = Matrix6d::Zero(), noise_ = Matrix6d::Zero();
  Matrix6d by_way_ = Matrix6d::Zero();  ///< d xi / d what every metre adds
  ScaleError scale_;
  double walked_ = 0;  ///< of the map's scale, as far as it was taken over
};

}  // namespace pavo
