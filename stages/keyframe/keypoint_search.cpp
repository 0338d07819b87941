#include "stages/keyframe/keypoint_search.h"

#include <algorithm>
#include <cmath>

namespace pavo {

float descriptor_distance2(const float* a, const float* b) {
  // Sixteen sums that do not wait for each other; in a fixed order, so that the result is the same everywhere.
  float sums[16] = {};
  for (int k = 0; k < Features::kDescriptorSize; k += 16)
    for (int i = 0; i < 16; ++i) {
      const float d = a[k + i] - b[k + i];
      sums[i] += d * d;
    }
  for (int half = 8; half > 0; half /= 2)
    for (int i = 0; i < half; ++i) sums[i] += sums[i + half];
  return sums[0];
}

void KeypointSearch::build(const Features& features, std::span<const std::uint8_t> keep, int width, int height) {
  features_ = &features;
  columns_ = width / kCell + 1;
  rows_ = height / kCell + 1;
  first_.assign(static_cast<std::size_t>(columns_ * rows_) + 1, 0);
  cell_.resize(features.size());
  for (std::size_t i = 0; i < features.size(); ++i) {
    const Keypoint& k = features.keypoints[i];
    cell_[i] = keep.empty() || keep[i] ? static_cast<int>(k.y) / kCell * columns_ + static_cast<int>(k.x) / kCell : -1;
    if (cell_[i] >= 0) ++first_[cell_[i] + 1];
  }
  for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
  items_.resize(features.size());
  for (std::size_t i = features.size(); i-- > 0;)
    if (cell_[i] >= 0) items_[--first_[cell_[i] + 1]] = static_cast<int>(i);
  // first_[c + 1] now is where cell c begins: shift back.
  std::rotate(first_.begin(), first_.begin() + 1, first_.end());
  first_.back() = static_cast<int>(std::count_if(cell_.begin(), cell_.end(), [](int c) { return c >= 0; }));
}

FoundKeypoint KeypointSearch::find(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double radius,
                                   const float* descriptor) const {
  FoundKeypoint found;
  found.distance2 = 4;
  const double length2 = (b - a).squaredNorm();
  const Eigen::Vector2d low = a.cwiseMin(b).array() - radius, high = a.cwiseMax(b).array() + radius;
  const int left = std::max(0, static_cast<int>(std::floor(low.x())) / kCell);
  const int right = std::min(columns_ - 1, static_cast<int>(std::floor(high.x())) / kCell);
  const int top = std::max(0, static_cast<int>(std::floor(low.y())) / kCell);
  const int bottom = std::min(rows_ - 1, static_cast<int>(std::floor(high.y())) / kCell);
  for (int row = top; row <= bottom; ++row) {
    for (int column = left; column <= right; ++column) {
      const int cell = row * columns_ + column;
      for (int n = first_[cell]; n < first_[cell + 1]; ++n) {
        const int index = items_[n];
        const Keypoint& k = features_->keypoints[index];
        const Eigen::Vector2d at(k.x, k.y);
        const double along = length2 > 0 ? std::clamp((at - a).dot(b - a) / length2, 0.0, 1.0) : 0.0;
        if ((a + along * (b - a) - at).squaredNorm() > radius * radius) continue;
        const float distance2 = descriptor_distance2(descriptor, features_->descriptor(index));
        if (distance2 < found.distance2) {
          found.second2 = found.distance2;
          found.distance2 = distance2;
          found.index = index;
        } else if (distance2 < found.second2) {
          found.second2 = distance2;
        }
      }
    }
  }
  return found;
}

}  // namespace pavo
