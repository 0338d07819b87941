#include "stages/features/fast.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/features/fast.cpp"
#include <hwy/foreach_target.h>  // compiles the part below once for every SIMD target
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pavo::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The circle, clockwise from the top.
struct Circle {
  explicit Circle(std::ptrdiff_t stride) {
    constexpr int dx[16] = {0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1};
    constexpr int dy[16] = {-3, -3, -2, -1, 0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3};
    for (int i = 0; i < 16; ++i) offset[i] = dy[i] * stride + dx[i];
  }
  std::ptrdiff_t offset[16];
};

/// max over all arcs of 9 of the arc's smallest value. The arcs that start at 2k and at 2k + 1 share 8 pixels, so that
/// max(min(shared, first), min(shared, last)) = min(shared, max(first, last)) serves two of them at once.
template <class V>
HWY_INLINE V max_of_arc_minima(const V* p) {
  V two[8], four[8];
  for (int k = 0; k < 8; ++k) two[k] = hn::Min(p[2 * k + 1], p[(2 * k + 2) % 16]);
  for (int k = 0; k < 8; ++k) four[k] = hn::Min(two[k], two[(k + 1) % 8]);
  V best = hn::Min(hn::Min(four[0], four[2]), hn::Max(p[0], p[9]));
  for (int k = 1; k < 8; ++k) {
    const V eight = hn::Min(four[k], four[(k + 2) % 8]);
    best = hn::Max(best, hn::Min(eight, hn::Max(p[2 * k], p[(2 * k + 9) % 16])));
  }
  return best;
}

template <class V>
HWY_INLINE V min_of_arc_maxima(const V* p) {
  V two[8], four[8];
  for (int k = 0; k < 8; ++k) two[k] = hn::Max(p[2 * k + 1], p[(2 * k + 2) % 16]);
  for (int k = 0; k < 8; ++k) four[k] = hn::Max(two[k], two[(k + 1) % 8]);
  V best = hn::Max(hn::Max(four[0], four[2]), hn::Min(p[0], p[9]));
  for (int k = 1; k < 8; ++k) {
    const V eight = hn::Max(four[k], four[(k + 2) % 8]);
    best = hn::Min(best, hn::Max(eight, hn::Min(p[2 * k], p[(2 * k + 9) % 16])));
  }
  return best;
}

/// The scores of Lanes(d) pixels from `center` on; 0 for those that are no corners.
template <class D>
HWY_INLINE void score_vector(D d, const std::uint8_t* center, const Circle& circle, hn::Vec<D> threshold,
                             std::uint8_t* HWY_RESTRICT scores) {
  using V = hn::Vec<D>;
  const V c = hn::LoadU(d, center);
  V p[16];
  for (int i = 0; i < 16; i += 4) p[i] = hn::LoadU(d, center + circle.offset[i]);
  // Any 9 neighbouring pixels hold two of the four compass points that are next to each other: a bound that is cheap.
  const V bright_bound = hn::Min(hn::Max(p[0], p[8]), hn::Max(p[4], p[12]));
  const V dark_bound = hn::Max(hn::Min(p[0], p[8]), hn::Min(p[4], p[12]));
  const V bound = hn::Max(hn::SaturatedSub(bright_bound, c), hn::SaturatedSub(c, dark_bound));
  if (hn::AllTrue(d, hn::Eq(hn::SaturatedSub(bound, threshold), hn::Zero(d)))) {
    hn::StoreU(hn::Zero(d), d, scores);
    return;
  }
  for (int i = 0; i < 16; ++i) {
    if (i % 4 != 0) p[i] = hn::LoadU(d, center + circle.offset[i]);
  }
  const V contrast = hn::Max(hn::SaturatedSub(max_of_arc_minima(p), c), hn::SaturatedSub(c, min_of_arc_maxima(p)));
  const auto corner = hn::Ne(hn::SaturatedSub(contrast, threshold), hn::Zero(d));
  hn::StoreU(hn::IfThenElseZero(corner, hn::Sub(contrast, hn::Set(d, 1))), d, scores);
}

/// The scores of one row's pixels [radius, width - radius), which must be at least Lanes(d) many.
template <class D>
void score_row(D d, const std::uint8_t* row, int width, const Circle& circle, std::uint8_t threshold,
               std::uint8_t* HWY_RESTRICT scores) {
  const auto t = hn::Set(d, threshold);
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int end = width - kFastRadius;
  int x = kFastRadius;
  for (; x + lanes <= end; x += lanes) score_vector(d, row + x, circle, t, scores + x);
  if (x < end) score_vector(d, row + end - lanes, circle, t, scores + end - lanes);  // overlaps: no read past the row
}

/// Appends the row's scores that are larger than all 8 around them. The rows can be read one vector past their ends.
Corner* keep_maxima(const std::uint8_t* above, const std::uint8_t* row, const std::uint8_t* below, int width, int y,
                    Corner* out) {
  const hn::ScalableTag<std::uint8_t> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int x = kFastRadius; x < width - kFastRadius; x += lanes) {
    const auto center = hn::LoadU(d, row + x);
    if (hn::AllTrue(d, hn::Eq(center, hn::Zero(d)))) continue;
    auto around = hn::Max(hn::LoadU(d, row + x - 1), hn::LoadU(d, row + x + 1));
    for (const std::uint8_t* neighbours : {above, below}) {
      around = hn::Max(around, hn::LoadU(d, neighbours + x));
      around = hn::Max(around, hn::Max(hn::LoadU(d, neighbours + x - 1), hn::LoadU(d, neighbours + x + 1)));
    }
    std::uint64_t bits[(HWY_MAX_BYTES + 63) / 64] = {};
    hn::StoreMaskBits(d, hn::Ne(hn::SaturatedSub(center, around), hn::Zero(d)), reinterpret_cast<std::uint8_t*>(bits));
    for (std::size_t word = 0; word < std::size(bits); ++word) {
      for (; bits[word] != 0; bits[word] &= bits[word] - 1) {
        const int at = x + static_cast<int>(64 * word + hwy::Num0BitsBelowLS1Bit_Nonzero64(bits[word]));
        *out++ = {static_cast<std::uint16_t>(at), static_cast<std::uint16_t>(y), row[at]};
      }
    }
  }
  return out;
}

/// Three rows of scores of `pitch` bytes, zero at first, go round; the middle one is searched when the next is there.
Corner* find_corners(const ImageView& image, int threshold, std::uint8_t* rows, std::size_t pitch, Corner* out) {
  const Circle circle(image.stride);
  const auto t = static_cast<std::uint8_t>(threshold);
  const int inner = image.width - 2 * kFastRadius;
  const hn::ScalableTag<std::uint8_t> d;
  const hn::CappedTag<std::uint8_t, 16> d16;
  const hn::CappedTag<std::uint8_t, 1> d1;
  std::uint8_t* above = rows;
  std::uint8_t* middle = rows + pitch;
  std::uint8_t* below = rows + 2 * pitch;
  for (int y = kFastRadius; y <= image.height - kFastRadius; ++y) {
    if (y == image.height - kFastRadius) {
      std::memset(below, 0, pitch);
    } else if (inner >= static_cast<int>(hn::Lanes(d))) {
      score_row(d, image.row(y), image.width, circle, t, below);
    } else if (inner >= static_cast<int>(hn::Lanes(d16))) {
      score_row(d16, image.row(y), image.width, circle, t, below);
    } else {
      score_row(d1, image.row(y), image.width, circle, t, below);
    }
    if (y > kFastRadius) out = keep_maxima(above, middle, below, image.width, y - 1, out);
    std::swap(above, middle);
    std::swap(middle, below);
  }
  return out;
}

}  // namespace pavo::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pavo {
HWY_EXPORT(find_corners);

namespace {

/// A row of scores is read up to one vector past its end, with any target.
constexpr std::size_t kRowSlack = 256;

void reserve(FastScratch& scratch, std::size_t rows_size, std::size_t corners_size) {
  if (scratch.rows_size < rows_size) {
    scratch.rows = hwy::AllocateAligned<std::uint8_t>(rows_size);
    scratch.rows_size = rows_size;
  }
  if (scratch.corners_size < corners_size) {
    scratch.corners = hwy::AllocateAligned<Corner>(corners_size);
    scratch.corners_size = corners_size;
  }
}

}  // namespace

std::span<Corner> detect_fast(ImageView image, int threshold, FastScratch& scratch) {
  if (image.width > 65535 || image.height > 65535) {
    throw std::runtime_error("FAST: an image of " + std::to_string(image.width) + "x" + std::to_string(image.height) +
                             " is larger than 65535 pixels a side");
  }
  if (image.width <= 2 * kFastRadius || image.height <= 2 * kFastRadius) return {};
  const auto half = [](int size) { return static_cast<std::size_t>(size - 2 * kFastRadius + 1) / 2; };
  const std::size_t pitch = static_cast<std::size_t>(image.width) + kRowSlack;
  reserve(scratch, 3 * pitch, half(image.width) * half(image.height));  // no two maxima touch: one in each 2x2 block
  std::memset(scratch.rows.get(), 0, 3 * pitch);
  Corner* end = HWY_DYNAMIC_DISPATCH(find_corners)(image, std::clamp(threshold, 0, 255), scratch.rows.get(), pitch,
                                                   scratch.corners.get());
  return {scratch.corners.get(), end};
}

}  // namespace pavo
#endif  // HWY_ONCE
