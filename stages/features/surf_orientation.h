// The dominant gradient around a keypoint.
#pragma once

#include <cstddef>
#include <cstdint>

#include "types/image.h"

namespace pavo {

struct SurfTables;

/// sums[y * pitch + x] is the sum of the pixels above and left of (x, y), modulo 2^32.
struct Integral {
  const std::uint32_t* sums = nullptr;
  std::ptrdiff_t pitch = 0;
  int width = 0, height = 0;  ///< of the image; there is one more row and column of sums
};

/// `sums` has room for (width + 1) * (height + 1).
Integral make_integral(ImageView image, std::uint32_t* sums);

/// A direction as a vector of any length, x right and y down; (0, 0) where there is no gradient.
struct Direction {
  float x = 0, y = 0;
};

/// The gradients in a circle of 6 s around the pixel position (x, y), where they can be read without leaving the image,
/// are summed over every window of 60 degrees of their directions, in steps of 5; the longest sum is the direction.
Direction dominant_gradient(const SurfTables& tables, const Integral& integral, float x, float y);

}  // namespace pavo
