// What an uncertain scale does to where the camera is: the way is longer or shorter than was thought, all of it.
#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace pavo {

/// The joint uncertainty of the camera's position and of s, the logarithm of the scale's error, as a Kalman filter
/// carries it. Every step dt is wrong by s dt, so position and scale are correlated, by `lag * variance`: where the
/// scale turns out to be wrong by ds, the camera is `lag * ds` from where it was thought to be. At the start of a map
/// that is the whole way from there; later, scale being known well and walking, the last few metres.
struct ScaleError {
  Eigen::Vector3d lag = Eigen::Vector3d::Zero();                ///< world frame, m
  Eigen::Matrix3d position_variance = Eigen::Matrix3d::Zero();  ///< what it adds to the position's, world frame
  double variance = 0;                                          ///< of s

  void travel(const Eigen::Vector3d& step) {
    const Eigen::Vector3d correlated = lag + 0.5 * step;
    position_variance += variance * (correlated * step.transpose() + step * correlated.transpose());
    lag += step;
  }
  /// s walks: what is known of it now says less about the way until here.
  void walk(double added_variance) {
    if (!(added_variance > 0)) return;
    lag *= variance / (variance + added_variance);
    variance += added_variance;
  }
  /// s was measured and corrected, the position left where it was.
  void measured(double variance_now) { variance = std::min(variance, variance_now); }
  /// All lengths are so many times as large.
  void rescale(double factor) {
    lag *= factor;
    position_variance *= factor * factor;
  }
  /// A new map begins, whose scale has an error of its own.
  void restart(double variance_of_new) {
    lag.setZero();
    variance = variance_of_new;
  }
};

}  // namespace pavo
