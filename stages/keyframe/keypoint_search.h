// The keypoints of one frame by place, and the one among them that looks most like a remembered point.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "stages/features/features.h"

namespace pavo {

struct FoundKeypoint {
  int index = -1;       ///< -1: none
  float distance2 = 0;  ///< of the descriptors, squared
  float second2 = 4;    ///< of the second nearest in the region
};

/// Built for each frame; allocates only to grow. One caller at a time.
class KeypointSearch {
 public:
  /// `keep`: 0 where a keypoint must not be found (it is on a person). The features have to outlive the searches.
  void build(const Features& features, std::span<const std::uint8_t> keep, int width, int height);

  /// The keypoint within `radius` of the segment from a to b (a == b: a disc) whose descriptor is nearest to
  /// `descriptor`.
  FoundKeypoint find(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double radius, const float* descriptor) const;

 private:
  static constexpr int kCell = 32;
  const Features* features_ = nullptr;
  int columns_ = 0, rows_ = 0;
  std::vector<int> first_;  ///< of each cell in items_
  std::vector<int> items_, cell_;
};

/// Squared distance of two descriptors.
float descriptor_distance2(const float* a, const float* b);

}  // namespace pavo
