// Points and where they are seen, as the loop over them reads them: eight at a time.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "stages/map/ray_point.h"

namespace pavo {

/// A point and where it is seen. What rho's uncertainty does to the pixel is part of the error's covariance,
/// sigma_px^2 I + g g^T sigma_rho^2 with g = d pixel / d rho: a point of unknown depth only says on which epipolar line
/// it lies, one at infinity only how the camera turned, and all of them are in one least-squares problem.
struct PoseConstraint {
  RayPoint ray;
  Eigen::Vector2d pixel;
  double sigma_px = 0.5;
};

/// One caller at a time. Only reserve(), and push_back() beyond it, allocate.
class PoseConstraints {
 public:
  static constexpr std::size_t kLanes = 8;

  /// The numbers of kLanes points. What is not filled is zero: of no weight.
  struct Block {
    alignas(64) double origin[3][kLanes]{}, direction[3][kLanes]{}, rho[kLanes]{}, rho_variance[kLanes]{};
    double pixel[2][kLanes]{}, information[kLanes]{};  // 1 / sigma_px^2
    double chi2[kLanes]{};                             // out
  };

  void reserve(std::size_t points) { blocks_.reserve((points + kLanes - 1) / kLanes); }
  void clear() { blocks_.clear(), size_ = 0; }
  void push_back(const PoseConstraint& c) {
    const std::size_t lane = size_++ % kLanes;
    if (lane == 0) blocks_.emplace_back();
    Block& b = blocks_.back();
    for (int i = 0; i < 3; ++i) b.origin[i][lane] = c.ray.origin(i), b.direction[i][lane] = c.ray.direction(i);
    for (int i = 0; i < 2; ++i) b.pixel[i][lane] = c.pixel(i);
    b.rho[lane] = c.ray.rho, b.rho_variance[lane] = c.ray.sigma_rho * c.ray.sigma_rho;
    b.information[lane] = 1 / (c.sigma_px * c.sigma_px);
  }

  std::size_t size() const { return size_; }
  /// Of the i-th, as refine_pose() left it: the squared error in standard deviations; huge behind the camera.
  double chi2(std::size_t i) const { return blocks_[i / kLanes].chi2[i % kLanes]; }

  /// All of them; the last one may be filled in part.
  std::span<Block> blocks() { return blocks_; }

 private:
  std::vector<Block> blocks_;
  std::size_t size_ = 0;
};

}  // namespace pavo
