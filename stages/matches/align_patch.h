// Where a remembered patch is now: the patch as it was seen once, resized to how near it is now, aligned to the image.
#pragma once

#include <array>
#include <cstdint>

#include "types/image.h"

namespace pavo {

/// The surroundings of a point, as some frame showed them.
struct Patch {
  static constexpr int kSize = 32;
  std::array<std::uint8_t, kSize * kSize> pixels{};
  float x = 0, y = 0;  ///< of the point, in the patch
};

struct AlignOptions {
  int iterations = 8;
  float epsilon_px = 0.02f;      ///< a step shorter than this ends the iteration
  float max_shift_px = 3.0f;     ///< from where it was expected
  float min_eigenvalue = 2.0f;   ///< of the mean squared gradient, (gray values a pixel)^2
  float min_correlation = 0.8f;  ///< of the aligned patches
};

struct Aligned {
  bool found = false;
  float x = 0, y = 0;     ///< pixel
  float correlation = 0;  ///< of the patches (zero-mean, normalised), 1: the same but for gain and offset
};

/// Remembers what surrounds (x, y). False, and `patch` untouched, where that reaches beyond the image.
bool take_patch(ImageView image, float x, float y, Patch& patch);

/// Finds `patch`, drawn `scale` times as large as it was, near (x, y): least squares over a translation; brightness and
/// contrast may differ. What is near the point counts more: 16 x 15 pixels with the point in their middle, weighed with
/// a standard deviation of 3.5 px. Inverse composition (Baker and Matthews, IJCV 2004). `scale` is brought into [0.6,
/// 2]. Pure; allocates nothing.
Aligned align_patch(const Patch& patch, float scale, ImageView image, float x, float y, const AlignOptions& options);

}  // namespace pavo
