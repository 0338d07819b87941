#include "stages/ground/scale_filter.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace pavo {
namespace {

// dm / d(ln |m|, pitch, roll)
Eigen::Matrix3d derivative(double length, const GroundAttitude& attitude) {
  Eigen::Matrix3d B;
  B.col(0) = length * down_of(attitude);
  B.rightCols<2>() = length * down_derivative(attitude);
  return B;
}

constexpr double kUnknownScale = 10;  // of the logarithm: anything

}  // namespace

ScaleFilter::ScaleFilter(const ScaleFilterOptions& options) : options_(options) {
  if (!(options.height_m > 0) || !std::isfinite(options.height_m))
    throw std::invalid_argument("scale: the camera's height has to be positive");
  x_ << 0, options.attitude.pitch_rad, options.attitude.roll_rad;
  P_.diagonal() << squared(kUnknownScale), squared(options.attitude_sigma), squared(options.attitude_sigma);
}

double ScaleFilter::metres_per_unit() const {
  return std::exp(told_);
}
double ScaleFilter::sigma() const {
  return std::sqrt(P_(0, 0) + squared(x_(0) - told_));
}

void ScaleFilter::predict(double scale_sigma) {
  P_(0, 0) += squared(scale_sigma);
  P_(1, 1) += squared(options_.attitude_walk);
  P_(2, 2) += squared(options_.attitude_walk);
}

void ScaleFilter::rescale(double factor) {
  x_(0) -= std::log(factor);
  told_ -= std::log(factor);
}

void ScaleFilter::retarget(double metres_per_unit) {
  rescale(std::exp(told_) / metres_per_unit);
}

void ScaleFilter::restart() {
  known_ = false;
  misses_ = strange_ways_ = 0;
  P_.row(0).setZero();
  P_.col(0).setZero();
  P_(0, 0) = squared(kUnknownScale);
}

void ScaleFilter::assume(double metres_per_unit, double sigma) {
  restart();
  x_(0) = told_ = std::log(metres_per_unit);
  P_(0, 0) = squared(sigma);
  known_ = true;
}

bool ScaleFilter::update(const GroundMeasurement& look) {
  if (!look.found) return false;
  const GroundAttitude attitude = attitude_of(look.m);
  const double length = look.m.norm();
  const Eigen::Matrix3d B = derivative(length, attitude);
  Eigen::Matrix3d information = B.transpose() * look.information * B;
  information.diagonal().array() += 1 / squared(kUnknownScale);
  Eigen::Matrix3d R = information.inverse();
  const Eigen::Vector3d said =
      Eigen::Vector3d(std::log(options_.height_m * length), attitude.pitch_rad, attitude.roll_rad) +
      R * B.transpose() * look.pull;
  R(0, 0) += squared(options_.height_sigma);
  // Ground that rises or falls does so from where it is seen: what is extrapolated to below the camera goes along.
  const Eigen::Vector3d tilt(options_.lever / look.slope, 1, 0);
  R += squared(options_.slope_sigma) * tilt * tilt.transpose();
  R(2, 2) += squared(options_.slope_sigma);
  const Eigen::Vector3d innovation = said - x_;
  const Eigen::Matrix3d gate_S = P_ + R;
  if (!(innovation.dot(gate_S.ldlt().solve(innovation)) < options_.gate)) {
    if (++misses_ >= options_.misses_until_lost) restart();
    return false;
  }
  misses_ = 0;
  const Eigen::Matrix3d S = P_ + options_.repetition * R;
  const Eigen::Matrix3d gain = P_ * S.inverse();
  x_ += gain * innovation;
  const Eigen::Matrix3d rest = Eigen::Matrix3d::Identity() - gain;
  P_ = rest * P_ * rest.transpose() + options_.repetition * gain * R * gain.transpose();
  told_ = x_(0);
  known_ = true;
  return true;
}

bool ScaleFilter::travelled(const Eigen::Vector3d& direction) {
  Eigen::Vector3d h = Eigen::Vector3d::Zero();
  h.tail<2>() = down_derivative(attitude()).transpose() * direction;
  const double innovation = -down_of(attitude()).dot(direction);
  const double R = squared(options_.travel_sigma), known = h.dot(P_ * h);
  if (squared(innovation) > options_.gate * (known + R)) {
    // The first ways of a map that was begun between people may be wrong, and what they said must not stay for ever.
    if (++strange_ways_ % options_.ways_until_doubt == 0) P_ *= squared(options_.doubt);
    return false;
  }
  strange_ways_ = 0;
  const Eigen::Vector3d gain = P_ * h / (known + options_.repetition * R);
  x_ += gain * innovation;
  const Eigen::Matrix3d rest = Eigen::Matrix3d::Identity() - gain * h.transpose();
  P_ = rest * P_ * rest.transpose() + options_.repetition * R * gain * gain.transpose();
  return true;
}

bool ScaleFilter::update(double metres_per_unit, double sigma) {
  if (!(metres_per_unit > 0) || !(sigma > 0)) return false;
  const double innovation = std::log(metres_per_unit) - x_(0);
  const double S = P_(0, 0) + squared(sigma);
  if (squared(innovation) > options_.gate * S) return false;
  const Eigen::Vector3d gain = P_.col(0) / S;
  x_ += gain * innovation;
  P_ -= gain * P_.row(0).eval();
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  told_ = x_(0);
  known_ = true;
  return true;
}

GroundPrior ScaleFilter::expected(double least_sigma) const {
  GroundPrior prior;
  const double length = std::exp(x_(0)) / options_.height_m;
  prior.m = length * down_of(attitude());
  const Eigen::Matrix3d B = derivative(length, attitude());
  Eigen::Matrix3d wide = P_;
  wide.row(0).setZero();
  wide.col(0).setZero();
  wide(0, 0) = std::max(4 * P_(0, 0), squared(least_sigma));
  wide(1, 1) += squared(options_.slope_sigma);
  wide(2, 2) += squared(options_.slope_sigma);
  prior.information = (B * wide * B.transpose()).inverse();
  return prior;
}

}  // namespace pavo
