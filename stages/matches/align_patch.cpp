#include "stages/matches/align_patch.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/matches/align_patch.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "stages/matches/patch-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pavo {
namespace HWY_NAMESPACE {

constexpr int kWide = 24;  // columns of the resized patch, with a border of one pixel, in whole vectors

struct Template {
  HWY_ALIGN float value[kPixels], gx[kPixels], gy[kPixels];
  float xx = 0, xy = 0, yy = 0, energy = 0;
};

HWY_INLINE float dot(const float* a, const float* b) {
  const D d;
  V sum = hn::Zero(d);
  for (int i = 0; i < kPixels; i += static_cast<int>(hn::Lanes(d)))
    sum = hn::MulAdd(hn::Load(d, a + i), hn::Load(d, b + i), sum);
  return sum_of(sum);
}

// a -= factor b
HWY_INLINE void subtract(float* a, float factor, const float* b) {
  const D d;
  const V f = hn::Set(d, factor);
  for (int i = 0; i < kPixels; i += static_cast<int>(hn::Lanes(d)))
    hn::Store(hn::NegMulAdd(f, hn::Load(d, b + i), hn::Load(d, a + i)), d, a + i);
}

// The patch, resized: (kHeight + 2) rows of (kWidth + 2) columns.
HWY_INLINE void resize(const Patch& patch, float scale, float* out) {
  const float step = 1 / scale;
  int column[kWidth + 2];
  float rest[kWidth + 2];
  for (int c = 0; c < kWidth + 2; ++c) {
    const float x = patch.x + static_cast<float>(c - 1 - kWidth / 2) * step;
    column[c] = std::clamp(static_cast<int>(std::floor(x)), 0, Patch::kSize - 2);
    rest[c] = x - static_cast<float>(column[c]);
  }
  for (int r = 0; r < kHeight + 2; ++r) {
    const float y = patch.y + static_cast<float>(r - 1 - kHeight / 2) * step;
    const int row = std::clamp(static_cast<int>(std::floor(y)), 0, Patch::kSize - 2);
    const float fy = y - static_cast<float>(row);
    const std::uint8_t* upper = patch.pixels.data() + row * Patch::kSize;
    const std::uint8_t* lower = upper + Patch::kSize;
    float blended[Patch::kSize];
    for (int c = 0; c < Patch::kSize; ++c)
      blended[c] = static_cast<float>(upper[c]) + fy * static_cast<float>(lower[c] - upper[c]);
    for (int c = 0; c < kWidth + 2; ++c)
      out[r * kWide + c] = blended[column[c]] + rest[c] * (blended[column[c] + 1] - blended[column[c]]);
  }
}

void make_template(const Patch& patch, float scale, Template& t) {
  const D d;
  HWY_ALIGN float wide[(kHeight + 2) * kWide];
  resize(patch, scale, wide);
  const V half = hn::Set(d, 0.5f);
  for (int r = 0; r < kHeight; ++r) {
    const float* row = wide + (r + 1) * kWide;
    for (int c = 0; c < kWidth; c += static_cast<int>(hn::Lanes(d))) {
      const int at = r * kWidth + c;
      hn::Store(hn::LoadU(d, row + c + 1), d, t.value + at);
      hn::Store(hn::Mul(half, hn::Sub(hn::LoadU(d, row + c + 2), hn::LoadU(d, row + c))), d, t.gx + at);
      hn::Store(hn::Mul(half, hn::Sub(hn::LoadU(d, row + kWide + c + 1), hn::LoadU(d, row - kWide + c + 1))), d,
                t.gy + at);
    }
  }
  // Brightness and contrast are two more unknowns: gradients less their share of the constant and of the patch itself
  // take them out of the other two.
  remove_mean(t.value), remove_mean(t.gx), remove_mean(t.gy);
  t.energy = dot(t.value, t.value);
  const float by_energy = 1 / HWY_MAX(t.energy, 1.0f);
  subtract(t.gx, dot(t.gx, t.value) * by_energy, t.value);
  subtract(t.gy, dot(t.gy, t.value) * by_energy, t.value);
  t.xx = dot(t.gx, t.gx), t.xy = dot(t.gx, t.gy), t.yy = dot(t.gy, t.gy);
}

// Sums over the image's patch c (bilinear) with the template t.
struct Sums {
  float x, y, value, sum, squared;
};

HWY_INLINE Sums compare(const Template& t, const ImageView& image, const PatchCorner& c) {
  const D d;
  V x = hn::Zero(d), y = x, value = x, sum = x, squared = x;
  for_each_gray(image, c, [&](int at, V gray) HWY_ATTR {
    x = hn::MulAdd(gray, hn::Load(d, t.gx + at), x), y = hn::MulAdd(gray, hn::Load(d, t.gy + at), y);
    value = hn::MulAdd(gray, hn::Load(d, t.value + at), value);
    sum = hn::Add(sum, gray), squared = hn::MulAdd(gray, gray, squared);
  });
  return {sum_of(x), sum_of(y), sum_of(value), sum_of(sum), sum_of(squared)};
}

Aligned Align(const Patch& patch, float scale, const ImageView& image, float x0, float y0,
              const AlignOptions& options) {
  Aligned result;
  Template t;
  make_template(patch, HWY_MIN(HWY_MAX(scale, 0.6f), 2.0f), t);
  if (!(smallest_eigenvalue(t.xx, t.xy, t.yy) >= options.min_eigenvalue * kPixels)) return result;
  const float determinant = t.xx * t.yy - t.xy * t.xy;
  float x = x0, y = y0;
  for (int i = 0; i < options.iterations; ++i) {
    const PatchCorner at = corner_of(x, y);
    if (!inside(at, image)) return result;
    const Sums s = compare(t, image, at);
    // The gradients are orthogonal to the constant and to the patch, so only the image's part counts; its contrast is
    // the patch's times `gain`.
    const float gain = s.value / t.energy;
    const float variance = s.squared - s.sum * s.sum / static_cast<float>(kPixels);
    result.correlation = s.value / std::sqrt(HWY_MAX(variance * t.energy, 1.0f));
    if (!(gain > 0.3f && gain < 3.0f)) return result;
    const float dx = (t.xy * s.y - t.yy * s.x) / (determinant * gain);
    const float dy = (t.xy * s.x - t.xx * s.y) / (determinant * gain);
    x += dx, y += dy;
    if (std::abs(x - x0) > options.max_shift_px || std::abs(y - y0) > options.max_shift_px) return result;
    if (dx * dx + dy * dy < options.epsilon_px * options.epsilon_px) break;
  }
  result.found = result.correlation >= options.min_correlation;
  result.x = x, result.y = y;
  return result;
}

}  // namespace HWY_NAMESPACE
}  // namespace pavo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pavo {

HWY_EXPORT(Align);

bool take_patch(ImageView image, float x, float y, Patch& patch) {
  constexpr int kHalf = Patch::kSize / 2;
  const int left = static_cast<int>(std::floor(x)) - kHalf + 1, top = static_cast<int>(std::floor(y)) - kHalf + 1;
  if (left < 0 || top < 0 || left + Patch::kSize > image.width || top + Patch::kSize > image.height) return false;
  for (int row = 0; row < Patch::kSize; ++row)
    std::memcpy(patch.pixels.data() + row * Patch::kSize, image.row(top + row) + left, Patch::kSize);
  patch.x = x - static_cast<float>(left);
  patch.y = y - static_cast<float>(top);
  return true;
}

Aligned align_patch(const Patch& patch, float scale, ImageView image, float x, float y, const AlignOptions& options) {
  return HWY_DYNAMIC_DISPATCH(Align)(patch, scale, image, x, y, options);
}

}  // namespace pavo
#endif  // HWY_ONCE
