// What the alignments of small patches share, compiled once for each SIMD target: included only by sources that Highway
// compiles again and again. (Hence its own kind of guard.)
#if defined(PAVO_STAGES_MATCHES_PATCH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PAVO_STAGES_MATCHES_PATCH_INL_H
#undef PAVO_STAGES_MATCHES_PATCH_INL_H
#else
#define PAVO_STAGES_MATCHES_PATCH_INL_H
#endif

#include <hwy/highway.h>

#include <cmath>
#include <cstdint>

#include "types/image.h"

HWY_BEFORE_NAMESPACE();
namespace pavo {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 8>;
using V = hn::Vec<D>;

// A patch is kWidth x kHeight gray values, rows of kWidth, without a gap: whole vectors on every target.
constexpr int kWidth = 16, kHeight = 15, kPixels = kWidth * kHeight;
// The point is in the middle, between two columns: were it on one, what grows or shrinks would be found to one side.
constexpr float kMiddleX = (kWidth - 1) / 2.0f, kMiddleY = (kHeight - 1) / 2.0f;

HWY_INLINE float sum_of(V v) {
  return hn::GetLane(hn::SumOfLanes(D(), v));
}

// The next pixels of a row.
HWY_INLINE V load_gray(const std::uint8_t* p) {
  const D d;
  const hn::Rebind<std::uint8_t, D> d8;
  const hn::Rebind<std::int32_t, D> d32;
  return hn::ConvertTo(d, hn::PromoteTo(d32, hn::LoadU(d8, p)));
}

// Where a patch with its middle at (x, y) begins.
struct PatchCorner {
  int x, y;      // whole pixels of the patch's top left
  float fx, fy;  // and the rest, [0, 1)
};

HWY_INLINE PatchCorner corner_of(float x, float y) {
  const float left = x - kMiddleX, top = y - kMiddleY;
  const float floor_x = std::floor(left), floor_y = std::floor(top);
  return {static_cast<int>(floor_x), static_cast<int>(floor_y), left - floor_x, top - floor_y};
}

// One more pixel is read on each side: by the interpolation or the gradient.
HWY_INLINE bool inside(const PatchCorner& c, const ImageView& image) {
  return c.x >= 1 && c.y >= 1 && c.x + kWidth + 1 < image.width && c.y + kHeight + 1 < image.height;
}

// use(i, gray) for each vector of the bilinearly interpolated patch at c, column by column of vectors; i: its place in
// the patch.
template <class Use>
HWY_INLINE void for_each_gray(const ImageView& image, const PatchCorner& c, const Use& use) {
  const D d;
  const V fx = hn::Set(d, c.fx), fy = hn::Set(d, c.fy);
  for (int column = 0; column < kWidth; column += static_cast<int>(hn::Lanes(d))) {
    const std::uint8_t* p = image.row(c.y) + c.x + column;
    V left = load_gray(p);
    V upper = hn::MulAdd(fx, hn::Sub(load_gray(p + 1), left), left);
    for (int row = 0; row < kHeight; ++row) {
      p += image.stride;
      left = load_gray(p);
      const V lower = hn::MulAdd(fx, hn::Sub(load_gray(p + 1), left), left);
      use(row * kWidth + column, hn::MulAdd(fy, hn::Sub(lower, upper), upper));
      upper = lower;
    }
  }
}

// The smaller eigenvalue of the normal equations' matrix (Shi and Tomasi 1994).
HWY_INLINE float smallest_eigenvalue(float xx, float xy, float yy) {
  const float trace = (xx + yy) / 2, determinant = xx * yy - xy * xy;
  return trace - std::sqrt(HWY_MAX(0.0f, trace * trace - determinant));
}

}  // namespace HWY_NAMESPACE
}  // namespace pavo
HWY_AFTER_NAMESPACE();

#endif  // per target
