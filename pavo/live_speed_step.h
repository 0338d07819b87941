// Step lengths from a wheel that is listened to while the run goes on.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "drivers/publishing/live_speed.h"
#include "stages/pose/scale.h"

namespace pavo {

/// Not integrated over a standstill, as SpeedStep. What has not arrived by the time it is asked for is taken from the
/// last sample, for half a second; then the motion model's speed goes on.
class LiveSpeedStep final : public StepLength {
 public:
  explicit LiveSpeedStep(const std::string& where) : speed_(where) {}
  double metres(const Step& step) const override { return speed_.distance_m(step.t_still_until_ns, step.t_to_ns); }
  bool metric() const override { return true; }
  SpeedCounts counts() const { return speed_.counts(); }

 private:
  LiveSpeed speed_;
};

}  // namespace pavo
