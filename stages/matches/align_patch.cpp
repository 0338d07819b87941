#include "stages/matches/align_patch.h"

#include <algorithm>
#include <array>
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

// What is near the point counts more. The farther from it, the more often a pixel shows something else, which is nearer
// or farther and moves otherwise, and the more does it matter that a surface seen from the side does not only grow.
// Tukey's biweight along rows and along columns; kPixels in all.
constexpr std::array<float, kPixels> make_window() {
  constexpr float kRadius = 9.25f;  // its standard deviation is 3.5 px
  const auto biweight = [](float distance) {
    const float rest = 1 - distance * distance / (kRadius * kRadius);
    return rest * rest;
  };
  std::array<float, kPixels> window{};
  float sum = 0;
  for (int r = 0; r < kHeight; ++r)
    for (int c = 0; c < kWidth; ++c)
      sum += window[r * kWidth + c] =
          biweight(static_cast<float>(r) - kMiddleY) * biweight(static_cast<float>(c) - kMiddleX);
  for (float& weight : window) weight *= kPixels / sum;
  return window;
}
alignas(64) constexpr std::array<float, kPixels> kWindow = make_window();

// Gray values and gradients, less what they have in common (see below), times the window.
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

HWY_INLINE void remove_weighted_mean(float* values) {
  const D d;
  const V mean = hn::Set(d, dot(values, kWindow.data()) / static_cast<float>(kPixels));
  for (int i = 0; i < kPixels; i += static_cast<int>(hn::Lanes(d)))
    hn::Store(hn::Sub(hn::Load(d, values + i), mean), d, values + i);
}

HWY_INLINE void weigh(const float* values, float* out) {
  const D d;
  for (int i = 0; i < kPixels; i += static_cast<int>(hn::Lanes(d)))
    hn::Store(hn::Mul(hn::Load(d, values + i), hn::Load(d, kWindow.data() + i)), d, out + i);
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
    const float x = patch.x + (static_cast<float>(c - 1) - kMiddleX) * step;
    column[c] = std::clamp(static_cast<int>(std::floor(x)), 0, Patch::kSize - 2);
    rest[c] = x - static_cast<float>(column[c]);
  }
  for (int r = 0; r < kHeight + 2; ++r) {
    const float y = patch.y + (static_cast<float>(r - 1) - kMiddleY) * step;
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
  HWY_ALIGN float wide[(kHeight + 2) * kWide], value[kPixels], gx[kPixels], gy[kPixels];
  resize(patch, scale, wide);
  const V half = hn::Set(d, 0.5f);
  for (int r = 0; r < kHeight; ++r) {
    const float* row = wide + (r + 1) * kWide;
    for (int c = 0; c < kWidth; c += static_cast<int>(hn::Lanes(d))) {
      const int at = r * kWidth + c;
      hn::Store(hn::LoadU(d, row + c + 1), d, value + at);
      hn::Store(hn::Mul(half, hn::Sub(hn::LoadU(d, row + c + 2), hn::LoadU(d, row + c))), d, gx + at);
      hn::Store(hn::Mul(half, hn::Sub(hn::LoadU(d, row + kWide + c + 1), hn::LoadU(d, row - kWide + c + 1))), d,
                gy + at);
    }
  }
  // Brightness and contrast are two more unknowns: gradients less their share of the constant and of the patch itself
  // take them out of the other two.
  remove_weighted_mean(value), remove_weighted_mean(gx), remove_weighted_mean(gy);
  weigh(value, t.value);
  t.energy = dot(value, t.value);
  const float by_energy = 1 / HWY_MAX(t.energy, 1.0f);
  subtract(gx, dot(gx, t.value) * by_energy, value);
  subtract(gy, dot(gy, t.value) * by_energy, value);
  weigh(gx, t.gx), weigh(gy, t.gy);
  t.xx = dot(gx, t.gx), t.xy = dot(gx, t.gy), t.yy = dot(gy, t.gy);
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
    const V weighed = hn::Mul(gray, hn::Load(d, kWindow.data() + at));
    sum = hn::Add(sum, weighed), squared = hn::MulAdd(gray, weighed, squared);
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
