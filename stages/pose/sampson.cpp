#include "stages/pose/sampson.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/pose/sampson.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pavo {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<float>;
using V = hn::Vec<D>;

struct Broadcast {
  explicit Broadcast(const SampsonModel& m) {
    const D d;
    f0 = hn::Set(d, m.f[0]), f1 = hn::Set(d, m.f[1]), f2 = hn::Set(d, m.f[2]);
    f3 = hn::Set(d, m.f[3]), f4 = hn::Set(d, m.f[4]), f5 = hn::Set(d, m.f[5]);
    f6 = hn::Set(d, m.f[6]), f7 = hn::Set(d, m.f[7]), f8 = hn::Set(d, m.f[8]);
  }
  V f0, f1, f2, f3, f4, f5, f6, f7, f8;
};

// Squared Sampson distances of the points i, i + 1, ...
HWY_INLINE V squared_distances(const Broadcast& F, const SampsonPoints& points, std::size_t i) {
  const D d;
  const V x = hn::Load(d, points.x_previous() + i), y = hn::Load(d, points.y_previous() + i);
  const V u = hn::Load(d, points.x_current() + i), v = hn::Load(d, points.y_current() + i);
  const V a = hn::MulAdd(F.f0, x, hn::MulAdd(F.f1, y, F.f2));  // F x: the line in the current image
  const V b = hn::MulAdd(F.f3, x, hn::MulAdd(F.f4, y, F.f5));
  const V c = hn::MulAdd(F.f6, x, hn::MulAdd(F.f7, y, F.f8));
  const V p = hn::MulAdd(F.f0, u, hn::MulAdd(F.f3, v, F.f6));  // F^T x': the line in the previous image
  const V q = hn::MulAdd(F.f1, u, hn::MulAdd(F.f4, v, F.f7));
  const V e = hn::MulAdd(u, a, hn::MulAdd(v, b, c));
  const V slope = hn::MulAdd(a, a, hn::MulAdd(b, b, hn::MulAdd(p, p, hn::Mul(q, q))));
  return hn::Div(hn::Mul(e, e), hn::Max(slope, hn::Set(d, 1e-30f)));
}

float Cost(const SampsonPoints& points, const SampsonModel& model, float limit, float give_up) {
  constexpr std::size_t kBlock = 128;  // points between two looks at give_up
  const D d;
  const Broadcast F(model);
  const V most = hn::Set(d, limit);
  const std::size_t n = points.size();
  float total = 0;
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    const std::size_t end = HWY_MIN(n, begin + kBlock);
    V sum = hn::Zero(d);
    std::size_t i = begin;
    for (; i + hn::Lanes(d) <= end; i += hn::Lanes(d)) {
      // NaN (a broken model) counts as an outlier: min's second operand wins on x86.
      sum = hn::Add(sum, hn::Min(squared_distances(F, points, i), most));
    }
    if (i < end) {
      const V rest = hn::Min(squared_distances(F, points, i), most);
      sum = hn::Add(sum, hn::IfThenElseZero(hn::FirstN(d, end - i), rest));
    }
    total += hn::GetLane(hn::SumOfLanes(d, sum));
    if (total > give_up) return total;
  }
  return total;
}

int Inliers(const SampsonPoints& points, const SampsonModel& model, float limit, std::uint8_t* is_inlier) {
  const D d;
  const Broadcast F(model);
  HWY_ALIGN float distances[hn::MaxLanes(d)];
  int inliers = 0;
  for (std::size_t i = 0; i < points.size(); i += hn::Lanes(d)) {
    hn::Store(squared_distances(F, points, i), d, distances);
    const std::size_t count = HWY_MIN(hn::Lanes(d), points.size() - i);
    for (std::size_t k = 0; k < count; ++k) {
      is_inlier[i + k] = distances[k] <= limit;
      inliers += distances[k] <= limit;
    }
  }
  return inliers;
}

}  // namespace HWY_NAMESPACE
}  // namespace pavo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pavo {

HWY_EXPORT(Cost);
HWY_EXPORT(Inliers);

namespace {
constexpr std::size_t kPad = 64;  // whole vectors may be loaded behind the last point, of any SIMD width
}

void SampsonPoints::reserve(std::size_t n) {
  if (n + kPad <= capacity_) return;
  capacity_ = (n + 2 * kPad - 1) / kPad * kPad;
  data_ = hwy::AllocateAligned<float>(4 * capacity_);
  size_ = 0;
}

void SampsonPoints::assign(std::span<const PointPair> pairs) {
  reserve(pairs.size());
  size_ = pairs.size();
  center_previous_.setZero();
  center_current_.setZero();
  for (const PointPair& pair : pairs) {
    center_previous_ += Eigen::Vector2d(pair.x_previous, pair.y_previous);
    center_current_ += Eigen::Vector2d(pair.x_current, pair.y_current);
  }
  if (size_ > 0) {  // whole pixels: subtracting them is exact
    center_previous_ = (center_previous_ / static_cast<double>(size_)).array().round();
    center_current_ = (center_current_ / static_cast<double>(size_)).array().round();
  }
  const Eigen::Vector2f previous = center_previous_.cast<float>(), current = center_current_.cast<float>();
  float* out = data_.get();
  for (std::size_t i = 0; i < size_; ++i) {
    out[i] = pairs[i].x_previous - previous.x();
    out[capacity_ + i] = pairs[i].y_previous - previous.y();
    out[2 * capacity_ + i] = pairs[i].x_current - current.x();
    out[3 * capacity_ + i] = pairs[i].y_current - current.y();
  }
  for (std::size_t row = 0; row < 4; ++row)
    std::fill(out + row * capacity_ + size_, out + std::min((row + 1) * capacity_, row * capacity_ + size_ + kPad),
              0.0f);
}

SampsonModel sampson_model(const Eigen::Matrix3d& F_pixels, const SampsonPoints& points) {
  Eigen::Matrix3d to_previous = Eigen::Matrix3d::Identity(), to_current = Eigen::Matrix3d::Identity();
  to_previous.topRightCorner<2, 1>() = points.center_previous();
  to_current.topRightCorner<2, 1>() = points.center_current();
  Eigen::Matrix3d F = to_current.transpose() * F_pixels * to_previous;
  // The distance does not depend on F's size, its float intermediates do: lines of about unit slope.
  const double size = F.topRows<2>().norm() + F.leftCols<2>().norm();
  if (size > 0) F /= size;
  SampsonModel model;
  for (int i = 0; i < 9; ++i) model.f[i] = static_cast<float>(F(i / 3, i % 3));
  return model;
}

float sampson_cost(const SampsonPoints& points, const SampsonModel& model, float threshold_px, float give_up) {
  return HWY_DYNAMIC_DISPATCH(Cost)(points, model, threshold_px * threshold_px, give_up);
}

int sampson_inliers(const SampsonPoints& points, const SampsonModel& model, float threshold_px,
                    std::span<std::uint8_t> is_inlier) {
  return HWY_DYNAMIC_DISPATCH(Inliers)(points, model, threshold_px * threshold_px, is_inlier.data());
}

double sampson_distance(const Eigen::Matrix3d& F_pixels, const PointPair& pair) {
  const Eigen::Vector3d p(pair.x_previous, pair.y_previous, 1), c(pair.x_current, pair.y_current, 1);
  const Eigen::Vector3d line_c = F_pixels * p, line_p = F_pixels.transpose() * c;
  const double slope = line_c.head<2>().squaredNorm() + line_p.head<2>().squaredNorm();
  return slope > 0 ? std::abs(c.dot(line_c)) / std::sqrt(slope) : 0;
}

}  // namespace pavo
#endif  // HWY_ONCE
