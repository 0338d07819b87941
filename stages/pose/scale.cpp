#include "stages/pose/scale.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>

namespace pavo {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

double seconds(std::int64_t from_ns, std::int64_t to_ns) {
  return static_cast<double>(to_ns - from_ns) * 1e-9;
}

}  // namespace

double UnitStep::metres(const Step& step) const {
  return static_cast<double>(std::max<std::int64_t>(1, step.to_frame - step.still_until_frame));
}

double UnknownStep::metres(const Step& /*step*/) const {
  return kUnknown;
}

SpeedStep::SpeedStep(std::vector<Sample> samples, double hold_s) : samples_(std::move(samples)), hold_s_(hold_s) {
  if (samples_.empty()) throw std::runtime_error("speed: no samples; expected at least one line of time and speed");
  distance_m_.assign(samples_.size(), 0.0);
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const std::string where = "speed: sample " + std::to_string(i + 1);
    if (!std::isfinite(samples_[i].m_per_s)) throw std::runtime_error(where + " is not a finite number of m/s");
    if (i == 0) continue;
    if (samples_[i].t_ns <= samples_[i - 1].t_ns) {
      throw std::runtime_error(where + " is not later than the one before it; expected times that increase");
    }
    distance_m_[i] = distance_m_[i - 1] + seconds(samples_[i - 1].t_ns, samples_[i].t_ns) * 0.5 *
                                              (samples_[i - 1].m_per_s + samples_[i].m_per_s);
  }
}

// The integral of the piecewise linear speed from the first sample to t.
double SpeedStep::distance_until(std::int64_t t_ns) const {
  const Sample& first = samples_.front();
  const Sample& last = samples_.back();
  if (t_ns <= first.t_ns) {
    const double s = seconds(t_ns, first.t_ns);
    return s > hold_s_ ? kUnknown : -s * first.m_per_s;
  }
  if (t_ns >= last.t_ns) {
    const double s = seconds(last.t_ns, t_ns);
    return s > hold_s_ ? kUnknown : distance_m_.back() + s * last.m_per_s;
  }
  const auto next = std::upper_bound(samples_.begin(), samples_.end(), t_ns,
                                     [](std::int64_t t, const Sample& sample) { return t < sample.t_ns; });
  const auto i = static_cast<std::size_t>(next - samples_.begin()) - 1;
  const double s = seconds(samples_[i].t_ns, t_ns);
  const double acceleration =
      (samples_[i + 1].m_per_s - samples_[i].m_per_s) / seconds(samples_[i].t_ns, samples_[i + 1].t_ns);
  return distance_m_[i] + s * (samples_[i].m_per_s + 0.5 * acceleration * s);
}

double SpeedStep::metres(const Step& step) const {
  return std::abs(distance_until(step.t_to_ns) - distance_until(step.t_still_until_ns));
}

GroundtruthStep::GroundtruthStep(const Trajectory& per_frame) {
  positions_.reserve(per_frame.T_w_c.size());
  for (const SE3& pose : per_frame.T_w_c) positions_.push_back(pose.t);
}

double GroundtruthStep::metres(const Step& step) const {
  const auto n = static_cast<std::int64_t>(positions_.size());
  if (step.from_frame < 0 || step.to_frame < 0 || step.from_frame >= n || step.to_frame >= n) return kUnknown;
  const double distance =
      (positions_[static_cast<std::size_t>(step.to_frame)] - positions_[static_cast<std::size_t>(step.from_frame)])
          .norm();
  return std::isfinite(distance) ? distance : kUnknown;
}

}  // namespace pavo
