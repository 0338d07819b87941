// Points along a street, keyframes that drive through it, and what they see of it.
#pragma once

#include <vector>

#include "stages/map/bundle_adjustment.h"
#include "tests/pose/scenes.h"

namespace pavo::test {

struct StreetOfPoints {
  std::vector<SE3> T_w_c;               ///< true poses
  std::vector<Eigen::Vector3d> points;  ///< true points
  Bundle bundle;                        ///< disturbed; the first two poses are true and fixed
};

inline StreetOfPoints street_of_points(std::uint64_t seed, std::size_t poses, std::size_t points, double noise_px,
                                       double outliers = 0) {
  Random random(seed);
  StreetOfPoints street;
  street.T_w_c.resize(1);
  while (street.T_w_c.size() < poses)
    street.T_w_c.push_back(street.T_w_c.back() * motion({0.002, 0.01, 0}, {0.02, -0.01, 0.8}));
  for (std::size_t i = 0; i < poses; ++i) {
    SE3 T = street.T_w_c[i];
    Vector6d off;
    for (int k = 0; k < 6; ++k) off[k] = (k < 3 ? 0.05 : 0.005) * gauss(random);
    const bool fixed = i < 2;
    street.bundle.poses.push_back({fixed ? T : moved_by(T, off), fixed});
  }
  while (street.bundle.points.size() < points) {
    const Eigen::Vector3d X(30 * random.uniform() - 15, 6 * random.uniform() - 4.5, 6 + 40 * random.uniform());
    BundlePoint point{.ray = {},
                      .first = static_cast<int>(street.bundle.observations.size()),
                      .count = 0,
                      .prior_rho = 0,
                      .prior_information = 0};
    for (std::size_t i = 0; i < poses; ++i) {
      const Eigen::Vector3d p = street.T_w_c[i].inverse() * X;
      if (p.z() < 1 || !inside(project(p))) continue;
      const double noise = random.uniform() < outliers ? 30 : noise_px;
      const Eigen::Vector2d x = project(p) + noise * Eigen::Vector2d(gauss(random), gauss(random));
      street.bundle.observations.push_back(
          {static_cast<int>(i), static_cast<int>(street.bundle.points.size()), x.x(), x.y(), 1 / 0.4});
      ++point.count;
    }
    if (point.count < 3) {
      street.bundle.observations.resize(static_cast<std::size_t>(point.first));
      continue;
    }
    const double depth = X.z() * (1 + 0.05 * gauss(random));
    point.ray.direction = {X.x() / X.z(), X.y() / X.z(), 1};
    point.ray.rho = 1 / depth;
    street.points.push_back(X);
    street.bundle.points.push_back(point);
  }
  return street;
}

}  // namespace pavo::test
