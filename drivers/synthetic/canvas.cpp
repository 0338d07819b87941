#include "drivers/synthetic/canvas.h"

#include <algorithm>
#include <cmath>

namespace pavo::synthetic {

Canvas::Canvas(float width_m, float height_m, int width, int height, bool repeat)
    : width_m_(width_m),
      height_m_(height_m),
      width_(width),
      height_(height),
      repeat_(repeat),
      sx_(static_cast<float>(width) / width_m),
      sy_(static_cast<float>(height) / height_m),
      values_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0.5F) {}

Grain::Grain(const Noise& noise) : tile_(kSize * kSize) {
  // octaves whose lattices divide the tile, so that it has no seam
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
      float sum = 0;
      for (const float cell : {2.0F, 4.0F, 8.0F}) {
        const auto wrapped = [&](float dx, float dy) { return noise(fx / cell + 100 * cell + dx, fy / cell + dy); };
        const float period = kSize / cell, a = fx / kSize, b = fy / kSize;  // cross-faded over the tile
        const float top = wrapped(0, 0) * (1 - a) + wrapped(-period, 0) * a;
        const float bottom = wrapped(0, -period) * (1 - a) + wrapped(-period, -period) * a;
        sum += 0.6F * (top * (1 - b) + bottom * b);
      }
      const int texel = y * kSize + x;
      tile_[static_cast<std::size_t>(texel)] = sum;
    }
}

void Canvas::add_grain(const Grain& grain, float strength, std::uint32_t seed) {
  const std::uint32_t x = hash(seed, 1), y = hash(seed, 2);
  for (int j = 0; j < height_; ++j)
    for (int i = 0; i < width_; ++i)
      at(i, j) += strength * grain.at(x + static_cast<std::uint32_t>(i), y + static_cast<std::uint32_t>(j));
}

/// coverage(x, y) of the texel whose centre is (x, y), in metres.
template <typename Coverage>
void Canvas::blend(float x0, float y0, float x1, float y1, float value, const Coverage& coverage) {
  const int i0 = static_cast<int>(std::floor(x0 * sx_)) - 1, i1 = static_cast<int>(std::ceil(x1 * sx_)) + 1;
  const int j0 = std::max(static_cast<int>(std::floor(y0 * sy_)) - 1, 0);
  const int j1 = std::min(static_cast<int>(std::ceil(y1 * sy_)) + 1, height_ - 1);
  for (int j = j0; j <= j1; ++j) {
    for (int i = i0; i <= i1; ++i) {
      if (!repeat_ && (i < 0 || i >= width_)) continue;
      const float a = coverage((static_cast<float>(i) + 0.5F) / sx_, (static_cast<float>(j) + 0.5F) / sy_);
      if (a <= 0) continue;
      float& texel = at(((i % width_) + width_) % width_, j);
      texel += a * (value - texel);
    }
  }
}

void Canvas::rectangle(float x0, float y0, float x1, float y1, float value, float opacity) {
  blend(x0, y0, x1, y1, value, [&](float x, float y) {
    const float wide = std::clamp(std::min(x - x0, x1 - x) * sx_ + 0.5F, 0.0F, 1.0F);
    const float tall = std::clamp(std::min(y - y0, y1 - y) * sy_ + 0.5F, 0.0F, 1.0F);
    return wide * tall * opacity;
  });
}

void Canvas::disc(float x, float y, float radius, float value, float opacity, float softness_m) {
  const float edge = std::max(softness_m, 1 / std::min(sx_, sy_));
  const float reach = radius + edge;
  blend(x - reach, y - reach, x + reach, y + reach, value, [&](float px, float py) {
    return std::clamp((radius - std::hypot(px - x, py - y)) / edge + 0.5F, 0.0F, 1.0F) * opacity;
  });
}

void Canvas::line(float x0, float y0, float x1, float y1, float width, float value, float opacity) {
  const float r = width / 2, dx = x1 - x0, dy = y1 - y0, length2 = std::max(dx * dx + dy * dy, 1e-12F);
  const float texels = std::min(sx_, sy_), thin = std::min(width * texels, 1.0F);
  blend(std::min(x0, x1) - r, std::min(y0, y1) - r, std::max(x0, x1) + r, std::max(y0, y1) + r, value,
        [&](float px, float py) {
          const float along = std::clamp(((px - x0) * dx + (py - y0) * dy) / length2, 0.0F, 1.0F);
          const float distance = std::hypot(px - x0 - along * dx, py - y0 - along * dy);
          return std::clamp((r - distance) * texels + 0.5F, 0.0F, thin) * opacity;
        });
}

void Canvas::pattern(float x0, float y0, float x1, float y1, const std::function<float(float, float, float)>& shade) {
  const int i0 = std::max(static_cast<int>(std::lround(x0 * sx_)), 0),
            i1 = std::min(static_cast<int>(std::lround(x1 * sx_)), width_);
  const int j0 = std::max(static_cast<int>(std::lround(y0 * sy_)), 0),
            j1 = std::min(static_cast<int>(std::lround(y1 * sy_)), height_);
  for (int j = j0; j < j1; ++j)
    for (int i = i0; i < i1; ++i)
      at(i, j) = shade((static_cast<float>(i) + 0.5F) / sx_, (static_cast<float>(j) + 0.5F) / sy_, at(i, j));
}

void Canvas::lettering(float x, float y, float height, int letters, float value, Random& random) {
  const float stroke = height * 0.16F, wide = height * 0.55F;
  for (int k = 0; k < letters; ++k, x += wide * 1.45F) {
    const auto shape = random.bits();
    if (shape % 7 == 0) continue;  // a space between words
    if (shape & 8) line(x, y, x, y + height, stroke, value);
    if (shape & 16) line(x + wide, y, x + wide, y + height, stroke, value);
    if (shape & 32) line(x, y, x + wide, y, stroke, value);
    if (shape & 64) line(x, y + height, x + wide, y + height, stroke, value);
    if (shape & 128) line(x, y + height / 2, x + wide, y + height / 2, stroke, value);
    if (shape & 256) line(x, y, x + wide, y + height, stroke, value);
    if (!(shape & 0x1f8)) line(x + wide / 2, y, x + wide / 2, y + height, stroke, value);
  }
}

Texture Canvas::texture() const {
  std::vector<std::uint8_t> texels(values_.size());
  std::transform(values_.begin(), values_.end(), texels.begin(),
                 [](float v) { return static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0F, 1.0F) * 255.0F)); });
  return {width_, height_, std::move(texels), repeat_};
}

}  // namespace pavo::synthetic
