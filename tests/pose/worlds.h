// A made-up world of points with descriptors of their own, and what a camera that drives through it sees.
#pragma once

#include <vector>

#include "stages/features/features.h"
#include "stages/pose/odometry.h"
#include "tests/pose/scenes.h"

namespace pavo::test {

class World {
 public:
  explicit World(std::uint64_t seed, std::size_t points = 1500) : seed_(seed) {
    Random random(seed);
    for (std::size_t i = 0; i < points; ++i)
      points_.push_back({60 * random.uniform() - 30, 8 * random.uniform() - 6, 80 * random.uniform()});
  }

  /// Up to 600 features of the points in view, with noise that depends on the frame.
  Features seen_from(const SE3& T_w_c, std::int64_t frame, double noise_px = 0.1) const {
    Features features;
    features.reserve(600);
    Random noise = Random::for_frame(seed_, frame);
    const SE3 T_c_w = T_w_c.inverse();
    for (std::size_t i = 0; i < points_.size() && features.size() < 600; ++i) {
      const Eigen::Vector3d p = T_c_w * points_[i];
      if (p.z() < 2) continue;
      const Eigen::Vector2d x = project(p) + noise_px * Eigen::Vector2d(gauss(noise), gauss(noise));
      if (!inside(x)) continue;
      features.keypoints.push_back({static_cast<float>(x.x()), static_cast<float>(x.y()), 20, 0});
      describe(i, features.descriptor(features.size() - 1));
    }
    return features;
  }

 private:
  void describe(std::size_t point, float* out) const {
    Random random = Random::for_frame(seed_ + 1, static_cast<std::int64_t>(point));
    float square = 0;
    for (int k = 0; k < Features::kDescriptorSize; ++k) {
      out[k] = static_cast<float>(gauss(random));
      square += out[k] * out[k];
    }
    for (int k = 0; k < Features::kDescriptorSize; ++k) out[k] /= std::sqrt(square);
  }

  std::uint64_t seed_;
  std::vector<Eigen::Vector3d> points_;
};

/// Frame n of a drive of half a metre a frame in a bend.
inline std::vector<SE3> drive(std::size_t frames) {
  std::vector<SE3> T_w_c(1);
  while (T_w_c.size() < frames) T_w_c.push_back(T_w_c.back() * motion({0, 0.01, 0}, {0.02, 0, 0.5}));
  return T_w_c;
}

inline FrameTime at(std::int64_t frame) {
  return {frame, frame * 100000000, 0};
}

inline std::shared_ptr<const StepLength> true_steps(const std::vector<SE3>& T_w_c) {
  Trajectory trajectory;
  trajectory.T_w_c = T_w_c;
  return std::make_shared<GroundtruthStep>(trajectory);
}

}  // namespace pavo::test
