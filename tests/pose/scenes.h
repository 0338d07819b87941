// Made-up scenes whose geometry is known.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "stages/matches/matches.h"
#include "stages/pose/random.h"
#include "types/camera.h"
#include "types/pose.h"

namespace pavo::test {

inline const Camera kCamera{1226, 370, 707, 707, 602, 183, Lens::rectified, {}};

inline double gauss(Random& random) {
  return std::sqrt(-2 * std::log(1 - random.uniform())) * std::cos(6.283185307179586 * random.uniform());
}

inline Eigen::Vector2d project(const Eigen::Vector3d& p) {
  return {kCamera.fx * p.x() / p.z() + kCamera.cx, kCamera.fy * p.y() / p.z() + kCamera.cy};
}

inline Eigen::Vector3d unproject(double x, double y, double depth) {
  return {(x - kCamera.cx) / kCamera.fx * depth, (y - kCamera.cy) / kCamera.fy * depth, depth};
}

inline bool inside(const Eigen::Vector2d& x) {
  return x.x() >= 0 && x.y() >= 0 && x.x() < kCamera.width && x.y() < kCamera.height;
}

inline SE3 motion(const Eigen::Vector3d& rotation_vector, const Eigen::Vector3d& t) {
  const double angle = rotation_vector.norm();
  return {
      angle > 0 ? Eigen::AngleAxisd(angle, rotation_vector / angle).toRotationMatrix() : Eigen::Matrix3d::Identity(),
      t};
}

/// A drive of 0.8 m ahead in a slight bend.
inline SE3 driving() {
  return motion({0.003, 0.02, -0.001}, {0.04, 0.01, -0.8});
}

enum class Shape { deep, plane };

struct Scene {
  std::size_t points = 400;
  double outlier_share = 0;
  double noise_px = 0.2;
  Shape shape = Shape::deep;
  SE3 T_c_p = driving();
  std::uint64_t seed = 1;
};

/// Pairs in random order; `truth` (if given) tells which are no outliers.
inline PointPairs pairs_of(const Scene& scene, std::vector<std::uint8_t>* truth = nullptr) {
  Random random(scene.seed);
  PointPairs pairs;
  std::vector<std::uint8_t> good;
  for (int tries = 0; pairs.size() < scene.points && tries < 100000; ++tries) {
    const Eigen::Vector2d x(random.uniform() * kCamera.width, random.uniform() * kCamera.height);
    double depth = 4 + 40 * random.uniform();
    if (scene.shape == Shape::plane) depth = 12 / (1 + 0.3 * (x.x() - 600) / 700 + 0.8 * (x.y() - 180) / 700);
    Eigen::Vector2d y = project(scene.T_c_p * unproject(x.x(), x.y(), depth));
    if (!inside(y)) continue;
    good.push_back(random.uniform() >= scene.outlier_share);
    if (good.back())
      y += scene.noise_px * Eigen::Vector2d(gauss(random), gauss(random));
    else
      y = {random.uniform() * kCamera.width, random.uniform() * kCamera.height};
    pairs.push_back(
        {static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(y.x()), static_cast<float>(y.y())});
  }
  if (truth) *truth = good;
  return pairs;
}

inline double degrees_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return 57.29577951308232 * std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0));
}
inline double degrees_between(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return 57.29577951308232 * Eigen::AngleAxisd(a.transpose() * b).angle();
}

inline bool orthonormal(const Eigen::Matrix3d& R) {
  return (R * R.transpose()).isIdentity(1e-9) && std::abs(R.determinant() - 1) < 1e-9;
}

}  // namespace pavo::test
