// Paths whose evaluation is known, and random ones.
#pragma once

#include <Eigen/Geometry>
#include <numbers>
#include <random>

#include "stages/evaluation/evaluation.h"
#include "types/pose.h"

namespace pavo::test {

inline Eigen::Matrix3d about_y(double angle_rad) {
  return Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
}

/// The same motion, count - 1 times.
inline Trajectory repeated(const SE3& motion, std::size_t count) {
  Trajectory path;
  SE3 pose;
  for (std::size_t i = 0; i < count; ++i) {
    path.T_w_c.push_back(pose);
    pose = pose * motion;
  }
  return path;
}

/// One metre a frame, straight ahead.
inline Trajectory straight(std::size_t count, double step_m = 1) {
  return repeated({Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, step_m)}, count);
}

/// A drive with turns and hills, that begins anywhere.
inline Trajectory wandering(std::size_t count, unsigned seed, double step_m = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Trajectory path;
  SE3 pose{about_y(normal(random)), Eigen::Vector3d(normal(random), normal(random), normal(random))};
  for (std::size_t i = 0; i < count; ++i) {
    path.T_w_c.push_back(pose);
    const Eigen::Vector3d turn = 0.05 * Eigen::Vector3d(normal(random), normal(random), normal(random));
    pose = pose * SE3{Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix(),
                      step_m * Eigen::Vector3d(0.1 * normal(random), 0.1 * normal(random), 1)};
  }
  return path;
}

/// With every motion a little off.
inline Trajectory disturbed(const Trajectory& path, unsigned seed, double scale = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Trajectory result;
  result.t_ns = path.t_ns;
  SE3 pose;
  result.T_w_c.push_back(pose);
  for (std::size_t i = 1; i < path.T_w_c.size(); ++i) {
    SE3 motion = path.T_w_c[i - 1].inverse() * path.T_w_c[i];
    const Eigen::Vector3d turn = 0.002 * Eigen::Vector3d(normal(random), normal(random), normal(random));
    motion.R = motion.R * Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    motion.t = scale * (motion.t + 0.02 * Eigen::Vector3d(normal(random), normal(random), normal(random)));
    pose = pose * motion;
    result.T_w_c.push_back(pose);
  }
  return result;
}

inline Trajectory moved(const Similarity& similarity, const Trajectory& path) {
  return transformed(similarity, path);
}

inline PosePairs pairs_of(const Trajectory& estimate, const Trajectory& truth) {
  return {estimate.T_w_c, truth.T_w_c, false, 0};
}

}  // namespace pavo::test
