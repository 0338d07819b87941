// Roofs, trees, the sky, parked cars.

#include <algorithm>
#include <bit>
#include <cmath>

#include "drivers/synthetic/canvas.h"
#include "drivers/synthetic/parallel.h"
#include "drivers/synthetic/surfaces.h"

namespace pavo::synthetic {
namespace {

constexpr int kFacades = 24, kWalls = 4, kCars = 6;

Canvas sheet(float w, float h, float texel_m) {
  return {w, h, std::max(static_cast<int>(w / texel_m), 8), std::max(static_cast<int>(h / texel_m), 8)};
}

Canvas repeating(float size, float texel_m, int most) {
  const int width =
      std::clamp(static_cast<int>(std::bit_floor(static_cast<unsigned>(1.4F * size / texel_m))), 32, most);
  return {size, size, width, width, true};
}

Surface surface(const Canvas& canvas) {
  return {canvas.texture(), canvas.width_m(), canvas.height_m()};
}

void wheel(Canvas& canvas, float x, float y, Random& r) {
  canvas.disc(x, y, 0.37F, 0.03F);
  canvas.disc(x, y, 0.31F, 0.07F);
  canvas.disc(x, y, 0.21F, r.uniform(0.5F, 0.7F));
  for (int i = 0; i < 5; ++i) {
    const float a = static_cast<float>(i) * 1.2566F + 0.3F;
    canvas.line(x + 0.07F * std::cos(a), y + 0.07F * std::sin(a), x + 0.19F * std::cos(a + 0.3F),
                y + 0.19F * std::sin(a + 0.3F), 0.06F, 0.12F);
  }
  canvas.disc(x, y, 0.045F, 0.8F);
}

/// Paint that mirrors the ground below, and the sky above its shoulder line.
void lacquer(Canvas& canvas, const Noise& noise, float tone, float offset) {
  canvas.fill([&](float x, float y) {
    const float mirror = y < 0.14F ? 0.2F : y < 0.42F ? 0.04F : -0.1F * (y - 0.4F);
    return tone * (1 + mirror) + mirror * 0.35F + 0.02F * noise(x * 2 + offset, y * 14) +
           0.012F * noise(x * 30 + offset, y * 30);
  });
}

Surface glass(const Noise& noise, float w, float h, float texel_m, float tone, Random& r) {
  Canvas canvas = sheet(w, h, texel_m);
  const float offset = r.uniform(0, 300);
  canvas.fill([&](float x, float y) {
    const float sky = noise.fractal(x * 1.5F + offset, y * 2, 3) + 0.6F * (1 - 2 * y / h);
    return 0.12F + 0.24F * std::clamp(sky, 0.0F, 1.0F) + 0.02F * noise(x * 20, y * 20 + offset);
  });
  if (w > 2) canvas.rectangle(0.45F * w, 0, 0.45F * w + 0.08F, h, 0.04F);
  canvas.rectangle(0, 0, w, 0.05F, tone);
  canvas.rectangle(0, 0, 0.06F, h, tone);
  canvas.rectangle(w - 0.06F, 0, w, h, tone);
  canvas.line(0, 0.06F, w, 0.06F, 0.02F, 0.05F);
  return surface(canvas);
}

}  // namespace

Surface paint_roof(const Noise& noise, std::uint32_t seed, float texel_m) {
  Canvas canvas = repeating(8, texel_m, 1024);
  canvas.fill([&](float x, float y) {
    const float row = std::floor(y / 0.32F), shifted = x + (static_cast<int>(row) & 1 ? 0.125F : 0);
    const float column = std::floor(shifted / 0.25F), in_y = y / 0.32F - row, in_x = shifted / 0.25F - column;
    const auto tile = static_cast<std::uint32_t>(static_cast<int>(column) % 32);
    const float tone = static_cast<float>(hash(seed, tile, static_cast<std::uint32_t>(row)) % 1000) * 1e-3F;
    return 0.27F + 0.1F * (tone - 0.5F) + 0.06F * std::sin(in_x * 3.14F) - (in_y > 0.85F ? 0.13F : 0) +
           0.05F * noise.fractal(x * 3, y * 3, 3);
  });
  return surface(canvas);
}

Surface paint_leaves(const Noise& noise, std::uint32_t seed, float texel_m) {
  Random r(hash(seed, 31));
  Canvas canvas = repeating(4, texel_m, 512);
  canvas.fill([](float, float) { return 0.04F; });  // what is dark is a hole
  for (int i = 0; i < 5200; ++i) {
    const float x = r.uniform(0, 4), y = r.uniform(0, 4), a = r.uniform(0, 6.28F), length = r.uniform(0.02F, 0.05F);
    if (noise(x * 5, y * 5) < -0.45F) continue;       // leaves come in bunches
    const float late = static_cast<float>(i) / 5200;  // those on top are in the light
    const float light = 0.16F + 0.3F * late + 0.14F * noise(x * 3, y * 3) + r.uniform(-0.08F, 0.16F);
    canvas.line(x, y, x + length * std::cos(a), y + length * std::sin(a), r.uniform(0.035F, 0.06F), light);
  }
  return surface(canvas);
}

Surface paint_bark(const Noise& noise, float texel_m) {
  Canvas canvas = repeating(2, texel_m, 256);
  canvas.fill([&](float x, float y) { return 0.5F + 0.25F * noise.fractal(x * 16, y * 3, 4, 0.7F); });
  return surface(canvas);
}

Surface paint_sky(const Noise& noise, std::uint32_t seed, float texel_m) {
  const int width = std::clamp(static_cast<int>(std::bit_floor(static_cast<unsigned>(60 / texel_m))), 256, 4096);
  Canvas canvas(6.2831853F, 1.5707963F, width, width / 4, true);  // azimuth, and how far below the zenith
  Random r(hash(seed, 32));
  const float shift = r.uniform(0, 100);
  canvas.fill([&](float x, float y) {
    const float up = 1.5707963F - y, ring_x = std::cos(x), ring_z = std::sin(x);
    const float height = std::max(std::sin(up), 0.06F);
    const float cloud =
        noise.fractal(ring_x * std::cos(up) / height * 0.8F + shift, ring_z * std::cos(up) / height * 0.8F + shift, 4);
    const float hills = 0.035F + 0.018F * noise.fractal(3 * ring_x + shift, 3 * ring_z, 5, 0.6F);
    if (up < hills) return 0.52F + 0.05F * noise(ring_x * 160, ring_z * 160 + y * 90);
    return 0.8F + 0.1F * std::clamp(cloud + 0.2F, -0.6F, 0.9F) + 0.06F * std::exp(-up * 6);
  });
  return surface(canvas);
}

CarPaint paint_car(const Noise& noise, std::uint32_t seed, float texel_m) {
  Random r(hash(seed, 33));
  const float tone = r.chance(0.5F) ? r.uniform(0.08F, 0.25F) : r.uniform(0.5F, 0.85F),
              line = std::max(tone - 0.2F, 0.03F);
  CarPaint paint;
  Canvas side = sheet(4.3F, 0.9F, texel_m);  // from the shoulder line to the ground, the front at the right
  lacquer(side, noise, tone, r.uniform(0, 200));
  side.rectangle(0.2F, 0.62F, 4.1F, 0.9F, 0.05F, 0.8F);
  for (const float x : {1.05F, 2.05F, 3.05F}) side.line(x, 0, x - 0.06F, 0.64F, 0.02F, line);
  for (const float x : {1.2F, 2.2F}) side.rectangle(x, 0.14F, x + 0.2F, 0.19F, line);
  side.line(0.1F, 0.32F, 4.2F, 0.27F, 0.03F, line, 0.6F);
  side.rectangle(0, 0.1F, 0.25F, 0.3F, 0.3F);
  side.rectangle(4, 0.12F, 4.3F, 0.28F, 0.8F);
  for (const float x : {0.8F, 3.45F}) wheel(side, x, 0.58F, r);
  paint.side = surface(side);
  for (const bool front : {true, false}) {
    Canvas end = sheet(1.74F, 0.9F, texel_m);
    lacquer(end, noise, tone, r.uniform(0, 200));
    end.rectangle(0, 0.68F, 1.74F, 0.9F, 0.05F, 0.85F);
    for (const float x : {0.05F, 1.29F}) end.rectangle(x, 0.1F, x + 0.4F, 0.28F, front ? 0.85F : 0.28F);
    if (front) end.rectangle(0.5F, 0.12F, 1.24F, 0.27F, 0.08F);
    end.rectangle(0.6F, 0.42F, 1.14F, 0.54F, 0.88F);
    end.lettering(0.65F, 0.445F, 0.07F, 8, 0.05F, r);
    end.line(0, 0.36F, 1.74F, 0.36F, 0.02F, line);
    (front ? paint.front : paint.rear) = surface(end);
  }
  paint.glass_side = glass(noise, 2.6F, 0.55F, texel_m, tone, r);
  paint.glass_end = glass(noise, 1.5F, 0.6F, texel_m, tone, r);
  Canvas top = sheet(2, 2, 2 * texel_m);
  top.fill([&](float x, float y) { return tone * 1.05F + 0.1F + 0.05F * noise(x * 2, y * 2); });
  paint.top = surface(top);
  return paint;
}

Surfaces paint_surfaces(std::uint32_t seed, float texel_m, int threads) {
  const Palette palette(hash(seed, 10));
  const Noise& noise = palette.noise;
  Surfaces s;
  s.facades.resize(kFacades);
  s.walls.resize(kWalls);
  s.cars.resize(kCars);
  const auto paint = [&](int i) {
    const auto n = hash(seed, 100, static_cast<std::uint32_t>(i));
    if (i == 0)
      s.road = paint_road(palette, n, texel_m);
    else if (i <= 2)
      s.sidewalk[i - 1] = paint_sidewalk(palette, n, texel_m);
    else if (i == 3)
      s.field = paint_field(noise, texel_m);
    else if (i == 4)
      s.roof = paint_roof(noise, n, texel_m);
    else if (i == 5)
      s.leaves = paint_leaves(noise, n, texel_m);
    else if (i == 6)
      s.bark = paint_bark(noise, texel_m);
    else if (i == 7)
      s.sky = paint_sky(noise, n, texel_m);
    else if (i < 8 + kWalls)
      s.walls[static_cast<std::size_t>(i - 8)] = paint_wall(palette, n, texel_m);
    else if (i < 8 + kWalls + kCars)
      s.cars[static_cast<std::size_t>(i - 8 - kWalls)] = paint_car(noise, n, texel_m);
    else
      s.facades[static_cast<std::size_t>(i - 8 - kWalls - kCars)] = paint_facade(palette, n, texel_m);
  };
  constexpr int kCount = 8 + kWalls + kCars + kFacades;
  for_each_index(kCount, threads, paint);
  return s;
}

}  // namespace pavo::synthetic
