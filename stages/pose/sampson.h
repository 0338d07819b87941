// How well an F explains matches: Sampson's first-order geometric distance, many matches at a time (SIMD).
#pragma once

#include <hwy/aligned_allocator.h>
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>

#include "stages/matches/matches.h"

namespace pavo {

/// Matches as four arrays, each relative to a centre of its image: floats lose no precision to the offset.
/// Keeps its memory; grows to the largest number of matches seen.
class SampsonPoints {
 public:
  void assign(std::span<const PointPair> pairs);
  void reserve(std::size_t n);  ///< room for so many; what is there goes where there was not
  std::size_t size() const { return size_; }
  const float* x_previous() const { return data_.get(); }
  const float* y_previous() const { return data_.get() + capacity_; }
  const float* x_current() const { return data_.get() + 2 * capacity_; }
  const float* y_current() const { return data_.get() + 3 * capacity_; }
  Eigen::Vector2d center_previous() const { return center_previous_; }
  Eigen::Vector2d center_current() const { return center_current_; }

 private:
  hwy::AlignedFreeUniquePtr<float[]> data_;
  std::size_t capacity_ = 0, size_ = 0;
  Eigen::Vector2d center_previous_ = Eigen::Vector2d::Zero(), center_current_ = Eigen::Vector2d::Zero();
};

/// An F between such points (x_c^T F x_p = 0), row-major.
struct SampsonModel {
  float f[9];
};
SampsonModel sampson_model(const Eigen::Matrix3d& F_pixels, const SampsonPoints& points);

/// The sum over all points of min(d^2, threshold_px^2), d the Sampson distance in pixels; ends early, with a value
/// > give_up, once it exceeds that. Pure; allocates nothing.
float sampson_cost(const SampsonPoints& points, const SampsonModel& model, float threshold_px, float give_up);

/// The number of points with d <= threshold_px; is_inlier[i] tells which (one per point).
int sampson_inliers(const SampsonPoints& points, const SampsonModel& model, float threshold_px,
                    std::span<std::uint8_t> is_inlier);

/// d of one pair, in double precision and pixels (Hartley and Zisserman, 11.4.3, its square root).
double sampson_distance(const Eigen::Matrix3d& F_pixels, const PointPair& pair);

}  // namespace pavo
