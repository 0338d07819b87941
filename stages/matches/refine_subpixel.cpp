#include "stages/matches/refine_subpixel.h"

#include <cmath>
#include <cstddef>
#include <stdexcept>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/matches/refine_subpixel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "stages/matches/patch-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pavo {
namespace HWY_NAMESPACE {

static_assert(kWidth == RefineSubpixel::kWidth && kHeight == RefineSubpixel::kHeight);

// The previous image's patch: its gray values and gradients, less their means.
struct Template {
  HWY_ALIGN float value[kPixels], gx[kPixels], gy[kPixels];
  float xx = 0, xy = 0, yy = 0;  // the normal equations' matrix
};

HWY_INLINE void remove_mean(float* values) {
  const D d;
  V sum = hn::Zero(d);
  for (int i = 0; i < kPixels; i += static_cast<int>(hn::Lanes(d))) sum = hn::Add(sum, hn::Load(d, values + i));
  const V mean = hn::Set(d, sum_of(sum) / static_cast<float>(kPixels));
  for (int i = 0; i < kPixels; i += static_cast<int>(hn::Lanes(d)))
    hn::Store(hn::Sub(hn::Load(d, values + i), mean), d, values + i);
}

HWY_INLINE void sample(const ImageView& image, const PatchCorner& c, float* out) {
  for_each_gray(image, c, [&](int at, V gray) HWY_ATTR { hn::Store(gray, D(), out + at); });
}

void make_template(const ImageView& image, const PatchCorner& c, Template& t) {
  const D d;
  sample(image, c, t.value);
  remove_mean(t.value);
  HWY_ALIGN float next[kPixels];
  const V half = hn::Set(d, 0.5f);
  const auto difference = [&](int dx, int dy, float* out) {
    sample(image, {c.x + dx, c.y + dy, c.fx, c.fy}, out);
    sample(image, {c.x - dx, c.y - dy, c.fx, c.fy}, next);
    for (int i = 0; i < kPixels; i += static_cast<int>(hn::Lanes(d)))
      hn::Store(hn::Mul(half, hn::Sub(hn::Load(d, out + i), hn::Load(d, next + i))), d, out + i);
    // The brightness' difference is a third unknown: gradients less their means take it out of the other two.
    remove_mean(out);
  };
  difference(1, 0, t.gx);
  difference(0, 1, t.gy);
  V xx = hn::Zero(d), xy = xx, yy = xx;
  for (int i = 0; i < kPixels; i += static_cast<int>(hn::Lanes(d))) {
    const V gx = hn::Load(d, t.gx + i), gy = hn::Load(d, t.gy + i);
    xx = hn::MulAdd(gx, gx, xx), xy = hn::MulAdd(gx, gy, xy), yy = hn::MulAdd(gy, gy, yy);
  }
  t.xx = sum_of(xx), t.xy = sum_of(xy), t.yy = sum_of(yy);
}

// Sums of gradient times difference, and the squared difference less its mean.
struct Difference {
  float x, y, squared;
};
HWY_INLINE Difference difference_of(const Template& t, const float* patch) {
  const D d;
  V x = hn::Zero(d), y = x, sum = x, squared = x;
  for (int i = 0; i < kPixels; i += static_cast<int>(hn::Lanes(d))) {
    const V e = hn::Sub(hn::Load(d, patch + i), hn::Load(d, t.value + i));
    x = hn::MulAdd(e, hn::Load(d, t.gx + i), x), y = hn::MulAdd(e, hn::Load(d, t.gy + i), y);
    sum = hn::Add(sum, e), squared = hn::MulAdd(e, e, squared);
  }
  const float total = sum_of(sum);
  return {sum_of(x), sum_of(y), sum_of(squared) - total * total / static_cast<float>(kPixels)};
}

bool align(const ImageView& previous, const ImageView& current, const RefineSubpixel::Options& options,
           PointPair& pair) {
  const PatchCorner from = corner_of(pair.x_previous, pair.y_previous);
  if (!inside(from, previous)) return false;
  Template t;
  make_template(previous, from, t);
  if (!(smallest_eigenvalue(t.xx, t.xy, t.yy) >= options.min_eigenvalue * kPixels)) return false;
  const float determinant = t.xx * t.yy - t.xy * t.xy;
  float x = pair.x_current, y = pair.y_current;
  HWY_ALIGN float patch[kPixels];
  for (int i = 0; i < options.iterations; ++i) {
    const PatchCorner at = corner_of(x, y);
    if (!inside(at, current)) return false;
    sample(current, at, patch);
    const Difference e = difference_of(t, patch);
    const float dx = (t.xy * e.y - t.yy * e.x) / determinant, dy = (t.xy * e.x - t.xx * e.y) / determinant;
    x += dx, y += dy;
    if (std::abs(x - pair.x_current) > options.max_shift_px || std::abs(y - pair.y_current) > options.max_shift_px)
      return false;
    const float limit = options.max_residual * options.max_residual * kPixels;
    if (dx * dx + dy * dy < options.epsilon_px * options.epsilon_px || i + 1 == options.iterations) {
      if (e.squared > limit) return false;
      break;
    }
  }
  pair.x_current = x, pair.y_current = y;
  return true;
}

int AlignAll(const ImageView& previous, const ImageView& current, const RefineSubpixel::Options& options,
             std::span<PointPair> pairs, std::uint8_t* refined) {
  int count = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    refined[i] = align(previous, current, options, pairs[i]);
    count += refined[i];
  }
  return count;
}

}  // namespace HWY_NAMESPACE
}  // namespace pavo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pavo {

HWY_EXPORT(AlignAll);

int RefineSubpixel::operator()(ImageView previous, ImageView current, std::span<PointPair> pairs,
                               std::span<std::uint8_t> refined) const {
  if (previous.width != current.width || previous.height != current.height)
    throw std::invalid_argument("sub-pixel: the two images' sizes differ");
  if (refined.size() != pairs.size()) throw std::invalid_argument("sub-pixel: one flag per pair");
  return HWY_DYNAMIC_DISPATCH(AlignAll)(previous, current, options_, pairs, refined.data());
}

}  // namespace pavo
#endif  // HWY_ONCE
