// Gray textures with mip levels, filtered over the footprint of a pixel: that is what keeps corners stable.
#pragma once

#include <cstdint>
#include <vector>

namespace pavo::synthetic {

/// How the texture coordinates (texels of level 0) change from one pixel to the next, right and down.
struct Footprint {
  float du_dx = 0, dv_dx = 0, du_dy = 0, dv_dy = 0;
};

/// Texel (i, j) covers [i, i+1) x [j, j+1). Beyond its edges a texture is clamped; along u it may repeat instead
/// (then its width is a power of two). Immutable, so shared between threads.
class Texture {
 public:
  Texture() = default;
  /// texels: width * height values, 0 to 255.
  Texture(int width, int height, std::vector<std::uint8_t> texels, bool repeat_u);

  int width() const { return levels_.empty() ? 0 : levels_[0].width; }
  int height() const { return levels_.empty() ? 0 : levels_[0].height; }

  /// The mean over the footprint around (u, v): trilinear taps along the longer axis of its parallelogram, each as
  /// wide as the shorter one (anisotropic filtering as graphics hardware does it; at most 16 : 1).
  float sample(float u, float v, const Footprint& footprint) const;
  /// The same for a footprint that is a square of this size.
  float sample(float u, float v, float size) const;

 private:
  struct Level {
    int width = 0, height = 0;
    std::vector<std::uint8_t> texels;
  };
  float tap(float u, float v, float lod) const;
  float bilinear(const Level& level, float u, float v) const;

  std::vector<Level> levels_;
  bool repeat_u_ = false;
};

}  // namespace pavo::synthetic
