// Asphalt with its marks, sidewalks, and what lies behind the houses.
#include <algorithm>
#include <bit>
#include <cmath>

#include "drivers/synthetic/canvas.h"
#include "drivers/synthetic/layout.h"
#include "drivers/synthetic/surfaces.h"

namespace pavo::synthetic {
namespace {

constexpr auto kPeriod = static_cast<float>(kGroundPeriod);
constexpr auto kHalfRoad = static_cast<float>(kKerb);

/// A canvas that repeats every kPeriod metres; the number of texels is the power of two next to what was asked for.
Canvas ground_canvas(float height_m, float texel_m) {
  const int wanted = static_cast<int>(kPeriod / texel_m);
  const int width = std::clamp(static_cast<int>(std::bit_floor(static_cast<unsigned>(wanted * 4 / 3))), 256, 16384);
  return {kPeriod, height_m, width, std::max(static_cast<int>(height_m / texel_m), 8), true};
}

void crack(Canvas& canvas, float x, float y, int steps, float width, Random& random) {
  float heading = random.uniform(-3.14F, 3.14F);
  const float dark = random.uniform(0.1F, 0.18F);
  for (int i = 0; i < steps; ++i) {
    heading += random.uniform(-0.6F, 0.6F);
    const float step = random.uniform(0.08F, 0.3F), nx = x + step * std::cos(heading),
                ny = y + step * std::sin(heading);
    canvas.line(x, y, nx, ny, width, dark, 0.85F);
    x = nx;
    y = ny;
    if (random.chance(0.06F) && steps - i > 4) crack(canvas, x, y, (steps - i) / 2, width * 0.7F, random);
  }
}

void manhole(Canvas& canvas, float x, float y, Random& random) {
  const float r = random.uniform(0.3F, 0.36F);
  canvas.disc(x, y, r + 0.07F, 0.22F, 0.8F);
  canvas.disc(x, y, r, random.uniform(0.24F, 0.36F));
  for (int i = -3; i <= 3; ++i)
    for (int j = -3; j <= 3; ++j)
      if (i * i + j * j < 11)
        canvas.disc(x + 0.085F * static_cast<float>(i), y + 0.085F * static_cast<float>(j), 0.028F,
                    (i + j) & 1 ? 0.12F : 0.5F);
}

void grate(Canvas& canvas, float x, float y) {
  canvas.rectangle(x - 0.3F, y - 0.2F, x + 0.3F, y + 0.2F, 0.4F);
  for (int i = 0; i < 6; ++i) {
    const float at = x - 0.25F + 0.09F * static_cast<float>(i);
    canvas.rectangle(at, y - 0.16F, at + 0.05F, y + 0.16F, 0.06F);
  }
}

void repairs(Canvas& canvas, const Noise& noise, Random& r) {
  for (int i = 0; i < 22; ++i) {
    const float x = r.uniform(0, kPeriod), y = r.uniform(0.3F, 8), w = r.uniform(0.5F, 4), h = r.uniform(0.4F, 1.6F);
    const float tone = r.uniform(0.25F, 0.4F), offset = r.uniform(0, 400);
    canvas.pattern(x, y, x + w, y + h, [&](float px, float py, float) {
      return tone + 0.07F * noise.fractal((px + offset) * 30, py * 30, 3, 0.7F);
    });
    for (const float edge : {y, y + h}) canvas.line(x, edge, x + w, edge, 0.035F, 0.11F, 0.9F);
    for (const float edge : {x, x + w}) canvas.line(edge, y, edge, y + h, 0.035F, 0.11F, 0.9F);
  }
  for (int i = 0; i < 46; ++i)
    crack(canvas, r.uniform(0, kPeriod), r.uniform(0, 2 * kHalfRoad), 8 + r.below(26), r.uniform(0.012F, 0.04F), r);
  for (int i = 0; i < 130; ++i)  // oil, gum, leaves
    canvas.disc(r.uniform(0, kPeriod), r.uniform(0.1F, 9.5F), r.uniform(0.02F, 0.16F),
                r.chance(0.6F) ? r.uniform(0.1F, 0.2F) : r.uniform(0.5F, 0.7F), r.uniform(0.3F, 0.9F), 0.02F);
  for (int i = 0; i < 24; ++i)
    canvas.disc(r.uniform(0, kPeriod), r.uniform(0.3F, 9.3F), r.uniform(0.2F, 0.7F), 0.17F, r.uniform(0.15F, 0.45F),
                0.35F);
}

void marks(Canvas& canvas, const Noise& noise, Random& r) {
  const auto worn = [&](float x0, float y0, float x1, float y1) {
    canvas.pattern(x0, y0, x1, y1, [&](float x, float y, float v) {
      const float wear = noise.fractal(x * 6, y * 6, 4, 0.7F);
      return wear > 0.55F ? v : 0.78F + 0.1F * wear;
    });
  };
  every(6.66F, 1, kPeriod, [&](float x) { worn(x, kHalfRoad - 0.07F, x + 3, kHalfRoad + 0.07F); });
  for (const float y : {kHalfRoad - 2.8F, kHalfRoad + 2.8F})
    every(1.25F, 0, kPeriod, [&](float x) { worn(x, y - 0.05F, x + 0.7F, y + 0.05F); });
  every(1, 0.5F, 2 * kHalfRoad - 0.6F, [&](float y) { worn(37, y, 40, y + 0.5F); });  // a zebra crossing
  for (const float x : {35.6F, 41.2F})
    worn(x, kHalfRoad + (x < 37 ? 0.1F : -2.6F), x + 0.3F, kHalfRoad + (x < 37 ? 2.6F : -0.1F));
  for (int i = 0; i < 3; ++i) {  // an arrow
    const float x = 12 + 24 * static_cast<float>(i) + r.uniform(0, 4), y = kHalfRoad + 1.4F;
    canvas.line(x, y, x + 1.6F, y, 0.15F, 0.8F, 0.9F);
    canvas.line(x + 1.5F, y - 0.3F, x + 2.3F, y, 0.16F, 0.8F, 0.9F);
    canvas.line(x + 1.5F, y + 0.3F, x + 2.3F, y, 0.16F, 0.8F, 0.9F);
  }
}

}  // namespace

Surface paint_road(const Palette& palette, std::uint32_t seed, float texel_m) {
  const Noise& noise = palette.noise;
  Random random(hash(seed, 11));
  Canvas canvas = ground_canvas(2 * kHalfRoad, texel_m);
  canvas.fill([](float, float) { return 0.34F; });
  canvas.add_grain(palette.grain, 0.1F, seed);
  canvas.add_smooth(
      [&](float x, float y) {
        const float track = std::abs(std::abs(y - kHalfRoad) - 1.5F) - 0.75F;  // from the middle of where tyres run
        return 0.04F * noise(x * 0.4F, y * 0.8F) + 0.04F * noise(x * 2.4F, y * 3.1F) -
               0.035F * std::exp(-8 * track * track);
      },
      0.08F);
  repairs(canvas, noise, random);
  marks(canvas, noise, random);
  for (int i = 0; i < 9; ++i) manhole(canvas, random.uniform(0, kPeriod), random.uniform(2, 7), random);
  for (int i = 0; i < 5; ++i)
    for (const float y : {0.28F, 2 * kHalfRoad - 0.28F})
      grate(canvas, 8 + 16 * static_cast<float>(i) + random.uniform(-3, 3), y);
  for (const float y : {0.0F, 2 * kHalfRoad}) canvas.line(0, y, kPeriod, y, 0.25F, 0.16F, 0.6F);  // the gutter
  canvas.line(0, 0, 0, 2 * kHalfRoad, 0.05F, 0.12F);  // where the texture starts again: a joint, as real asphalt has
  return {canvas.texture(), kPeriod, 2 * kHalfRoad};
}

Surface paint_sidewalk(const Palette& palette, std::uint32_t seed, float texel_m) {
  const Noise& noise = palette.noise;
  constexpr float kWide = 5.5F, kSlabX = 0.8F, kSlabY = 0.6F;
  Random random(hash(seed, 12));
  Canvas canvas = ground_canvas(kWide, texel_m);
  canvas.fill([&](float x, float y) {
    if (y < 0.16F) {  // the kerb stone
      const float joint = std::abs(x - std::round(x));
      return joint < 0.01F ? 0.3F : 0.62F;
    }
    const float row = std::floor((y - 0.16F) / kSlabY), shifted = x + (static_cast<int>(row) & 1 ? kSlabX / 2 : 0);
    const float column = std::floor(shifted / kSlabX);
    const float in_x = shifted - column * kSlabX, in_y = y - 0.16F - row * kSlabY;
    const auto slab = static_cast<std::uint32_t>(static_cast<int>(column) % static_cast<int>(kPeriod / kSlabX));
    const float tone = static_cast<float>(hash(seed, slab, static_cast<std::uint32_t>(row)) % 1000) * 1e-3F;
    if (std::min(in_x, in_y) < 0.014F) return 0.27F;
    return 0.46F + 0.17F * (tone - 0.5F) - (y > 3.2F ? 0.04F * (y - 3.2F) : 0.0F);
  });
  canvas.add_grain(palette.grain, 0.085F, seed);
  canvas.add_smooth([&](float x, float y) { return 0.05F * noise.fractal(x * 0.8F, y * 1.3F, 3); }, 0.1F);
  for (int i = 0; i < 420; ++i)
    canvas.disc(random.uniform(0, kPeriod), random.uniform(0.2F, 5), random.uniform(0.015F, 0.05F),
                random.chance(0.7F) ? 0.2F : 0.75F, random.uniform(0.4F, 0.9F));
  for (int i = 0; i < 16; ++i) crack(canvas, random.uniform(0, kPeriod), random.uniform(0.3F, 4), 10, 0.015F, random);
  for (int i = 0; i < 8; ++i) grate(canvas, random.uniform(0, kPeriod), random.uniform(0.8F, 3));
  for (int i = 0; i < 9; ++i) {
    const float x = random.uniform(0, kPeriod), y = random.uniform(0.5F, 2.6F), w = random.uniform(0.4F, 1.8F),
                h = random.uniform(0.4F, 0.9F);
    canvas.rectangle(x, y, x + w, y + h, random.uniform(0.22F, 0.36F), 0.9F);
  }
  return {canvas.texture(), kPeriod, kWide};
}

Surface paint_field(const Noise& noise, float texel_m) {
  constexpr float kSize = 16;
  const int width = std::clamp(static_cast<int>(std::bit_floor(static_cast<unsigned>(kSize / texel_m))), 64, 1024);
  Canvas canvas(kSize, kSize, width, width, true);
  canvas.fill([&](float x, float y) { return 0.3F + 0.12F * noise.fractal(x * 4, y * 4, 5, 0.7F); });
  return {canvas.texture(), kSize, kSize};
}

}  // namespace pavo::synthetic
