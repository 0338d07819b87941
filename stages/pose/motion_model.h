// Constant velocity: where the camera is if it goes on as it did.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "types/pose.h"

namespace pavo {

/// Which frame it is, and when it was taken.
struct FrameTime {
  std::int64_t index = 0;        ///< of the frame in the source, from 0
  std::int64_t t_ns = 0;         ///< capture time
  std::int64_t lost_before = 0;  ///< frames lost between the previous frame and this one ("gap")
};

/// Remembers the last observed step and repeats it, scaled with time (with the frames' indices where times stand still
/// or run backwards). At rest until a step was observed. Not thread-safe; allocates nothing.
class MotionModel {
 public:
  /// The camera moved by T_from_to (its pose at `to` in its frame at `from`).
  void observe(const SE3& T_from_to, const FrameTime& from, const FrameTime& to) {
    step_ = T_from_to;
    from_ = from;
    to_ = to;
  }

  /// Lengths turned out to be so many times as large.
  void scale(double factor) { step_.t *= factor; }

  /// The step from one frame to a later one, at the velocity last observed.
  SE3 predict(const FrameTime& from, const FrameTime& to) const {
    const double ratio = std::clamp(intervals(from, to), 0.0, kMaxIntervals);
    if (ratio == 1.0) return step_;
    const Eigen::AngleAxisd rotation(step_.R);
    return {Eigen::AngleAxisd(rotation.angle() * ratio, rotation.axis()).toRotationMatrix(), step_.t * ratio};
  }

 private:
  // Constant velocity says nothing about what comes minutes later.
  static constexpr double kMaxIntervals = 20;

  double intervals(const FrameTime& from, const FrameTime& to) const {
    const double observed_ns = static_cast<double>(to_.t_ns - from_.t_ns),
                 asked_ns = static_cast<double>(to.t_ns - from.t_ns);
    if (observed_ns > 0 && asked_ns > 0) return asked_ns / observed_ns;
    const double observed = static_cast<double>(std::max<std::int64_t>(1, to_.index - from_.index));
    return static_cast<double>(std::max<std::int64_t>(1, to.index - from.index)) / observed;
  }

  SE3 step_;
  FrameTime from_, to_{1, 0, 0};
};

}  // namespace pavo
