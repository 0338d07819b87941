// FAST-9/16: a pixel is a corner when 9 neighbouring pixels of the 16 on a circle of radius 3 around it are all
// brighter, or all darker, than it by more than a threshold (Rosten and Drummond, ECCV 2006; Rosten, Porter, Drummond,
// PAMI 2010).
#pragma once

#include <hwy/aligned_allocator.h>
#include <cstddef>
#include <cstdint>
#include <span>

#include "types/image.h"

namespace pavo {

/// A corner at an integer pixel. The score is the largest threshold at which it still is a corner.
struct Corner {
  std::uint16_t x = 0, y = 0;
  std::uint8_t score = 0;

  friend bool operator==(const Corner&, const Corner&) = default;
};

/// What detect_fast() works in and returns its corners in. One per caller at a time.
struct FastScratch {
  hwy::AlignedFreeUniquePtr<std::uint8_t[]> rows;  ///< the scores of three rows
  std::size_t rows_size = 0;
  hwy::AlignedFreeUniquePtr<Corner[]> corners;  ///< as many as non-maximum suppression can leave
  std::size_t corners_size = 0;
};

/// How far the circle reaches from its centre, in pixels. Pixels nearer to the border are never corners.
inline constexpr int kFastRadius = 3;

/// The corners whose score is at least `threshold` (clamped to 0..255) and larger than those of their 8 neighbours, row
/// by row from the top, each row from the left: the same as OpenCV's FAST with non-maximum suppression, for any image
/// size up to 65535. They live in `scratch`, for the caller to sort out, until it is used again. Allocates only when a
/// larger image than ever before comes; may be called from any thread with a scratch of its own.
std::span<Corner> detect_fast(ImageView image, int threshold, FastScratch& scratch);

}  // namespace pavo
