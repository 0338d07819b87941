// The textures of the street, painted from a seed.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/synthetic/canvas.h"
#include "drivers/synthetic/random.h"
#include "drivers/synthetic/texture.h"

namespace pavo::synthetic {

/// A texture with its size in the world.
struct Surface {
  Texture texture;
  float width_m = 1, height_m = 1;
  float texels_u() const { return static_cast<float>(texture.width()) / width_m; }
  float texels_v() const { return static_cast<float>(texture.height()) / height_m; }
};

struct Facade {
  Surface front;
  bool pitched_roof = true;  ///< else a flat one
  int side = 0;              ///< which of the plain walls its gables are made of
};

struct CarPaint {
  Surface side, front, rear, glass_side, glass_end, top;
};

/// All of them. texel_m is the size of a texel on what is near the camera: what a pixel sees there.
struct Surfaces {
  std::vector<Facade> facades;
  std::vector<Surface> walls;  ///< plain, for the sides of houses
  Surface roof, road, sidewalk[2], field, leaves, bark, sky;
  std::vector<CarPaint> cars;
};

/// Painted by `threads` threads (0: one per core); the same to the bit for any number of them.
Surfaces paint_surfaces(std::uint32_t seed, float texel_m, int threads);

/// What all painters use.
struct Palette {
  explicit Palette(std::uint32_t seed) : noise(seed), grain(noise) {}
  Noise noise;
  Grain grain;
};

// The painters of the parts, one by one.
Surface paint_road(const Palette& palette, std::uint32_t seed, float texel_m);
Surface paint_sidewalk(const Palette& palette, std::uint32_t seed, float texel_m);
Surface paint_field(const Noise& noise, float texel_m);
Facade paint_facade(const Palette& palette, std::uint32_t seed, float texel_m);
Surface paint_wall(const Palette& palette, std::uint32_t seed, float texel_m);
Surface paint_roof(const Noise& noise, std::uint32_t seed, float texel_m);
Surface paint_leaves(const Noise& noise, std::uint32_t seed, float texel_m);
Surface paint_bark(const Noise& noise, float texel_m);
Surface paint_sky(const Noise& noise, std::uint32_t seed, float texel_m);  ///< u: azimuth, v: elevation
CarPaint paint_car(const Noise& noise, std::uint32_t seed, float texel_m);

}  // namespace pavo::synthetic
