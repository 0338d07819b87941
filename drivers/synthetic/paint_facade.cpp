// The fronts of houses: masonry, windows, doors, shops.
#include <algorithm>
#include <cmath>

#include "drivers/synthetic/canvas.h"
#include "drivers/synthetic/surfaces.h"

namespace pavo::synthetic {
namespace {

enum class Masonry { brick, plaster, ashlar };

/// What one house has in common over its front.
struct Style {
  Masonry masonry;
  float tone, mortar, frame, glass;
  float bay_m, window_w, window_h;
  int mullions;
  bool shutters, lintels, balconies;
  std::uint32_t seed;
};

float course(float x, float y, float wide, float tall, float joint, const Style& s, float spread) {
  const float row = std::floor(y / tall), shifted = x + (static_cast<int>(row) & 1 ? wide / 2 : 0);
  const float column = std::floor(shifted / wide);
  if (y - row * tall < joint || shifted - column * wide < joint) return s.mortar;
  const auto i = static_cast<std::uint32_t>(static_cast<int>(column) + 1000),
             j = static_cast<std::uint32_t>(static_cast<int>(row) + 1000);
  return s.tone + spread * (static_cast<float>(hash(s.seed, i, j) % 1024) / 1024 - 0.5F);
}

void masonry(Canvas& canvas, const Palette& palette, const Style& s, float offset) {
  const Noise& noise = palette.noise;
  const float height = canvas.height_m();
  canvas.fill([&](float x, float y) {
    if (s.masonry == Masonry::brick) return course(x, y, 0.24F, 0.08F, 0.013F, s, 0.2F);
    if (s.masonry == Masonry::ashlar) return course(x, y, 0.7F, 0.36F, 0.02F, s, 0.13F);
    return s.tone;
  });
  canvas.add_grain(palette.grain, s.masonry == Masonry::plaster ? 0.07F : 0.055F, s.seed);
  canvas.add_smooth(
      [&](float x, float y) {
        const float stains =
            0.09F * noise.fractal(x * 0.6F + offset, y * 0.5F, 4) + 0.035F * noise(x * 5 + offset, y * 0.4F);
        return stains - 0.12F * std::max(0.0F, 1 - (height - y) / (0.7F + 0.3F * noise(x * 1.3F + offset, 3)));
      },
      0.1F);
}

void blotches(Canvas& canvas, const Style& s, Random& r) {
  const int count = static_cast<int>(canvas.width_m() * (s.masonry == Masonry::plaster ? 5 : 2));
  for (int i = 0; i < count; ++i) {  // where plaster came off, bricks were replaced, cables are fixed
    const float x = r.uniform(0, canvas.width_m()), y = r.uniform(0.3F, canvas.height_m());
    const float tone = s.tone + r.uniform(-0.22F, 0.16F);
    if (r.chance(0.5F))
      canvas.rectangle(x, y, x + r.uniform(0.06F, 0.4F), y + r.uniform(0.05F, 0.25F), tone, 0.8F);
    else
      canvas.disc(x, y, r.uniform(0.03F, 0.2F), tone, 0.6F, 0.04F);
  }
}

void pane(Canvas& canvas, const Noise& noise, float x0, float y0, float x1, float y1, const Style& s, Random& r) {
  const float slope = r.uniform(-0.6F, 0.6F), sky = r.uniform(0.05F, 0.34F), offset = r.uniform(0, 300);
  canvas.pattern(x0, y0, x1, y1, [&](float x, float y, float) {  // the sky and the house opposite, mirrored
    const float up = (y1 - y) / (y1 - y0);
    return s.glass + sky * (up + slope * (x - x0) > 0.45F + 0.2F * noise(x * 3 + offset, y) ? 1.0F : 0.15F) +
           0.05F * noise(x * 6 + offset, y * 6);
  });
  const float inside = r.unit(), w = x1 - x0, h = y1 - y0;
  if (inside < 0.4F) {  // curtains
    const float tone = r.uniform(0.4F, 0.75F), part = r.uniform(0.15F, 0.4F);
    for (const float at : {x0, x1 - part * w})
      canvas.pattern(at, y0, at + part * w, y1,
                     [&](float x, float, float) { return tone + 0.09F * std::sin(x * 55 + offset); });
  } else if (inside < 0.65F) {  // blinds
    const float down = r.uniform(0.2F, 1), tone = r.uniform(0.45F, 0.7F);
    canvas.pattern(x0, y0, x1, y0 + down * h,
                   [&](float, float y, float) { return tone + (std::sin(y * 90) > 0 ? 0.06F : -0.07F); });
  } else if (inside < 0.8F) {
    canvas.rectangle(x0 + 0.2F * w, y1 - 0.3F * h, x0 + r.uniform(0.4F, 0.8F) * w, y1, r.uniform(0.05F, 0.6F));
    canvas.disc(x0 + 0.4F * w, y1 - 0.35F * h, 0.16F * w, r.uniform(0.15F, 0.5F));
  }
}

void window(Canvas& canvas, const Noise& noise, float x, float y, float w, float h, const Style& s, Random& r) {
  constexpr float kFrame = 0.06F;
  if (s.shutters) {
    const float tone = r.uniform(0.18F, 0.3F), wide = 0.45F * w;
    for (const float at : {x - wide - 0.02F, x + w + 0.02F})
      canvas.pattern(at, y, at + wide, y + h,
                     [&](float, float py, float) { return tone + (std::sin(py * 100) > 0.3F ? 0.1F : 0.0F); });
  }
  canvas.rectangle(x - 0.1F, y - 0.12F, x + w + 0.1F, y + h + 0.05F, s.lintels ? s.tone + 0.22F : s.tone - 0.06F);
  canvas.rectangle(x, y, x + w, y + h, s.frame);
  canvas.rectangle(x, y, x + w, y + 0.035F, 0.1F, 0.7F);  // the shadow of the reveal
  const int columns = s.mullions, rows = h > 1.7F ? 2 : 1;
  const float pane_w = (w - kFrame) / static_cast<float>(columns), split = rows == 2 ? 0.3F : 0.0F;
  for (int c = 0; c < columns; ++c) {
    const float px = x + kFrame + static_cast<float>(c) * pane_w;
    if (rows == 2) pane(canvas, noise, px, y + kFrame, px + pane_w - kFrame, y + split * h - kFrame / 2, s, r);
    pane(canvas, noise, px, y + split * h + kFrame, px + pane_w - kFrame, y + h - kFrame, s, r);
  }
  canvas.rectangle(x - 0.14F, y + h + 0.02F, x + w + 0.14F, y + h + 0.1F, std::min(s.tone + 0.28F, 0.92F));
  canvas.rectangle(x - 0.12F, y + h + 0.1F, x + w + 0.12F, y + h + 0.15F, 0.14F, 0.6F);
  if (r.chance(0.16F))  // flowers
    for (int i = 0; i < 26; ++i)
      canvas.disc(x + r.uniform(0, w), y + h - r.uniform(0, 0.28F), r.uniform(0.03F, 0.08F), r.uniform(0.1F, 0.75F));
}

void balcony(Canvas& canvas, float x, float y, float w) {
  canvas.rectangle(x, y + 0.95F, x + w, y + 1.1F, 0.7F);
  canvas.rectangle(x, y + 1.1F, x + w, y + 1.2F, 0.15F, 0.7F);
  canvas.rectangle(x, y, x + w, y + 0.05F, 0.1F);
  every(0.13F, x, x + w, [&](float at) { canvas.line(at, y, at, y + 0.95F, 0.03F, 0.1F); });
}

void door(Canvas& canvas, const Noise& noise, float x, float bottom, const Style& s, Random& r) {
  const float w = r.uniform(1, 1.5F), h = 2.3F, tone = r.uniform(0.12F, 0.5F), top = bottom - h;
  canvas.rectangle(x - 0.12F, top - 0.15F, x + w + 0.12F, bottom, std::min(s.tone + 0.2F, 0.85F));
  canvas.rectangle(x, top, x + w, bottom, tone);
  pane(canvas, noise, x + 0.12F, top + 0.1F, x + w - 0.12F, top + 0.5F, s, r);
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) {
      const float px = x + 0.1F + static_cast<float>(i) * (w / 2 - 0.03F),
                  py = top + 0.68F + static_cast<float>(j) * 0.8F;
      canvas.rectangle(px, py, px + w / 2 - 0.17F, py + 0.65F, tone - 0.08F);
      canvas.rectangle(px, py + 0.62F, px + w / 2 - 0.17F, py + 0.66F, tone + 0.2F);
    }
  canvas.disc(x + w - 0.1F, top + 1.25F, 0.04F, 0.85F);
  canvas.rectangle(x + w + 0.2F, top + 0.5F, x + w + 0.42F, top + 0.68F, 0.85F);  // the number
  canvas.lettering(x + w + 0.24F, top + 0.54F, 0.1F, 2, 0.1F, r);
  canvas.rectangle(x - 0.2F, bottom - 0.16F, x + w + 0.2F, bottom, 0.55F);
}

void shop(Canvas& canvas, const Noise& noise, float x0, float x1, float bottom, const Style& s, Random& r) {
  const float sign = r.uniform(0.12F, 0.8F), top = bottom - 3.1F;
  canvas.rectangle(x0, top, x1, top + 0.62F, sign);
  canvas.lettering(x0 + r.uniform(0.2F, 0.8F), top + 0.14F, 0.34F, static_cast<int>((x1 - x0 - 1) / 0.29F),
                   sign < 0.45F ? 0.9F : 0.08F, r);
  for (float x = x0 + 0.1F; x < x1 - 1;) {
    const float w = std::min(r.uniform(1.2F, 2.6F), x1 - 0.1F - x);
    canvas.rectangle(x, top + 0.7F, x + w - 0.06F, bottom - 0.4F, s.frame);
    pane(canvas, noise, x + 0.06F, top + 0.76F, x + w - 0.12F, bottom - 0.46F, s, r);
    for (int i = 0; i < 9; ++i) {  // what is for sale
      const float px = x + r.uniform(0.1F, std::max(w - 0.5F, 0.12F)), py = bottom - 0.5F - r.uniform(0, 1.3F);
      canvas.rectangle(px, py - r.uniform(0.1F, 0.5F), std::min(px + r.uniform(0.08F, 0.4F), x + w - 0.14F), py,
                       r.uniform(0.05F, 0.9F));
    }
    x += w;
  }
  if (r.chance(0.5F)) {
    const float light = r.uniform(0.7F, 0.9F), dark = r.uniform(0.15F, 0.4F);
    canvas.pattern(x0, top + 0.62F, x1, top + 1.05F, [&](float x, float y, float) {
      const bool scallop = y > top + 0.97F + 0.06F * std::sin(x * 18);
      return (std::fmod(x, 0.5F) < 0.25F ? light : dark) * (scallop ? 0.6F : 1.0F);
    });
  }
}

void furnish(Canvas& canvas, Random& r, const Style& s) {
  const float w = canvas.width_m(), h = canvas.height_m();
  const float pipe = r.chance(0.5F) ? 0.25F : w - 0.25F;
  canvas.line(pipe - 0.06F, 0.3F, pipe - 0.06F, h, 0.05F, 0.1F, 0.5F);
  canvas.line(pipe, 0.3F, pipe, h, 0.1F, std::clamp(s.tone - 0.2F, 0.15F, 0.8F));
  every(1.9F, 1, h, [&](float y) { canvas.rectangle(pipe - 0.08F, y, pipe + 0.08F, y + 0.06F, 0.12F); });
  for (int i = 0; i < 3; ++i) {  // posters, graffiti
    const float x = r.uniform(0.4F, w - 1.4F), y = h - r.uniform(0.9F, 1.9F);
    if (r.chance(0.4F)) {
      canvas.rectangle(x, y - 0.3F, x + 0.5F, y + 0.4F, r.uniform(0.6F, 0.9F));
      canvas.rectangle(x + 0.06F, y - 0.24F, x + 0.44F, y + 0.1F, r.uniform(0.1F, 0.5F));
      canvas.lettering(x + 0.06F, y + 0.17F, 0.12F, 5, 0.1F, r);
    } else if (r.chance(0.5F)) {
      float px = x, py = y;
      for (int k = 0; k < 9; ++k) {
        const float nx = px + r.uniform(-0.12F, 0.3F), ny = y + r.uniform(-0.35F, 0.35F);
        canvas.line(px, py, nx, ny, 0.06F, s.tone > 0.4F ? 0.1F : 0.8F, 0.85F);
        px = nx;
        py = ny;
      }
    }
  }
}

Style make_style(std::uint32_t seed, Random& r) {
  Style s{};
  s.masonry = static_cast<Masonry>(r.below(3));
  s.tone = s.masonry == Masonry::brick ? r.uniform(0.28F, 0.46F) : r.uniform(0.42F, 0.72F);
  s.mortar = s.masonry == Masonry::brick ? s.tone + r.uniform(0.08F, 0.2F) : s.tone - 0.14F;
  s.frame = r.chance(0.7F) ? r.uniform(0.7F, 0.92F) : r.uniform(0.1F, 0.25F);
  s.glass = r.uniform(0.08F, 0.16F);
  s.bay_m = r.uniform(2.1F, 3);
  s.window_w = r.uniform(0.9F, 1.25F);
  s.window_h = r.uniform(1.3F, 1.9F);
  s.mullions = 1 + r.below(3);
  s.shutters = s.bay_m > 2.5F && r.chance(0.35F);
  s.lintels = r.chance(0.6F);
  s.balconies = r.chance(0.25F);
  s.seed = seed;
  return s;
}

void ground_floor(Canvas& canvas, const Noise& noise, const Style& s, float floor_h, int bays, float margin,
                  Random& r) {
  const float w = canvas.width_m(), h = canvas.height_m();
  if (r.chance(0.35F)) {
    shop(canvas, noise, 0.5F, w - 2.2F, h, s, r);
    door(canvas, noise, w - 1.9F, h, s, r);
    return;
  }
  const int entrance = r.below(bays);
  for (int i = 0; i < bays; ++i) {
    const float x = margin + (static_cast<float>(i) + 0.5F) * s.bay_m;
    if (i == entrance)
      door(canvas, noise, x - 0.6F, h, s, r);
    else
      window(canvas, noise, x - s.window_w / 2, h - floor_h + 0.75F, s.window_w, s.window_h, s, r);
  }
  canvas.modify([&](float, float y, float v) { return y > h - 0.55F ? 0.75F * v : v; });  // the base course
}

}  // namespace

Facade paint_facade(const Palette& palette, std::uint32_t seed, float texel_m) {
  const Noise& noise = palette.noise;
  Random r(hash(seed, 21));
  Style s = make_style(seed, r);
  const int bays = 3 + r.below(4), floors = 2 + r.below(3);
  const float floor_h = r.uniform(2.8F, 3.2F), base_h = 3.5F, margin = 0.5F;
  const float w = 2 * margin + static_cast<float>(bays) * s.bay_m;
  const float h = base_h + static_cast<float>(floors - 1) * floor_h + 0.7F;
  Canvas canvas(w, h, std::max(static_cast<int>(w / texel_m), 8), std::max(static_cast<int>(h / texel_m), 8));
  masonry(canvas, palette, s, r.uniform(0, 500));
  blotches(canvas, s, r);
  for (int floor = 1; floor < floors; ++floor) {
    const float top = h - base_h - static_cast<float>(floor) * floor_h + 0.55F;
    for (int i = 0; i < bays; ++i) {
      const float x = margin + (static_cast<float>(i) + 0.5F) * s.bay_m;
      if (r.chance(0.04F)) continue;
      window(canvas, noise, x - s.window_w / 2, top, s.window_w, s.window_h, s, r);
      if (s.balconies && (i & 1)) balcony(canvas, x - 0.9F, top + 0.75F, 1.8F);
    }
    if (s.lintels) canvas.rectangle(0, top + s.window_h + 0.45F, w, top + s.window_h + 0.57F, s.tone + 0.15F);
  }
  ground_floor(canvas, noise, s, base_h, bays, margin, r);
  furnish(canvas, r, s);
  canvas.rectangle(0, 0, w, 0.22F, std::min(s.tone + 0.25F, 0.9F));  // the eaves
  canvas.rectangle(0, 0.22F, w, 0.36F, 0.16F, 0.75F);
  return {{canvas.texture(), w, h}, r.chance(0.7F), r.below(4)};
}

Surface paint_wall(const Palette& palette, std::uint32_t seed, float texel_m) {
  const Noise& noise = palette.noise;
  constexpr float kWide = 12, kTall = 16;
  Random r(hash(seed, 22));
  const Style s = make_style(seed, r);
  Canvas canvas(kWide, kTall, std::max(static_cast<int>(kWide / texel_m), 8),
                std::max(static_cast<int>(kTall / texel_m), 8));
  masonry(canvas, palette, s, r.uniform(0, 500));
  blotches(canvas, s, r);
  for (int i = 0; i < 4; ++i)
    window(canvas, noise, r.uniform(1, 10), 1.5F + 3.2F * static_cast<float>(i), 0.8F, 1.2F, s, r);
  furnish(canvas, r, s);
  return {canvas.texture(), kWide, kTall};
}

}  // namespace pavo::synthetic
