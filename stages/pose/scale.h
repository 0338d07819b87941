// How long a step is. One camera sees the direction of its motion, never its length: that has to come from outside.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "types/pose.h"

namespace pavo {

/// Two processed frames, an earlier and a later one, between which the length of the camera's way is asked. The camera
/// stood still from the first one until a frame in between, or not at all (then that is the first one).
struct Step {
  std::int64_t from_frame = 0, still_until_frame = 0, to_frame = 0;  ///< indices in the source
  std::int64_t t_from_ns = 0, t_still_until_ns = 0, t_to_ns = 0;
};

/// Where step lengths come from. Const and without state: may be called by any thread, neither blocks nor allocates.
class StepLength {
 public:
  virtual ~StepLength() = default;
  /// The distance between the camera's positions at the two frames (metres where metric()), >= 0.
  /// NaN where it is not known: the motion model's speed is taken then.
  virtual double metres(const Step& step) const = 0;
  /// False: lengths have no unit, and "0" or "1" is all that a step can tell.
  virtual bool metric() const = 0;
};

/// 1 for every frame since the camera stood still, so that a frame lost in between leaves no dent in the
/// path.
class UnitStep final : public StepLength {
 public:
  double metres(const Step& step) const override;
  bool metric() const override { return false; }
};

/// Speed over time, linear between its samples, integrated from frame to frame; held constant for at most
/// `hold_s` before the first and behind the last sample (NaN beyond). Not integrated over a standstill, where a speed
/// sensor's noise would add up.
class SpeedStep final : public StepLength {
 public:
  struct Sample {
    std::int64_t t_ns = 0;
    double m_per_s = 0;
  };
  /// The samples' times have to increase and the speeds to be finite; throws std::runtime_error that names the sample.
  explicit SpeedStep(std::vector<Sample> samples, double hold_s = 0.5);
  double metres(const Step& step) const override;
  bool metric() const override { return true; }

 private:
  double distance_until(std::int64_t t_ns) const;

  std::vector<Sample> samples_;
  std::vector<double> distance_m_;  ///< driven from the first sample to this one
  double hold_s_;
};

/// Nothing is known from outside: the ground tells the steps' lengths (OdometryOptions::ground), and where it is hidden
/// the motion model does.
class UnknownStep final : public StepLength {
 public:
  double metres(const Step& step) const override;
  bool metric() const override { return true; }
};

/// Distance between true positions: nothing but its length is read, never a direction or a rotation.
class GroundtruthStep final : public StepLength {
 public:
  /// positions[i]: of frame i, in metres; NaN where there is none.
  explicit GroundtruthStep(std::vector<Eigen::Vector3d> positions) : positions_(std::move(positions)) {}
  explicit GroundtruthStep(const Trajectory& per_frame);
  double metres(const Step& step) const override;
  bool metric() const override { return true; }

 private:
  std::vector<Eigen::Vector3d> positions_;
};

}  // namespace pavo
