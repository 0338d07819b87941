// A sheet, measured in metres, on which the street's surfaces are painted before they become textures.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "drivers/synthetic/random.h"
#include "drivers/synthetic/texture.h"

namespace pavo::synthetic {

/// A tile of noise, computed once: octaves of 2, 4 and 8 texels, about -1 to 1; it repeats.
class Grain {
 public:
  static constexpr int kSize = 256;
  explicit Grain(const Noise& noise);
  float at(std::uint32_t x, std::uint32_t y) const { return tile_[(y % kSize) * kSize + x % kSize]; }

 private:
  std::vector<float> tile_;
};

/// f(at) for at = from, from + step, ... below `to`: how rows of equal things are painted.
template <typename F>
void every(float step, float from, float to, const F& f) {
  while (from < to) {
    f(from);
    from += step;
  }
}

/// Gray values 0 (black) to 1 (white) over [0, width_m] x [0, height_m]; x to the right, y down. Edges of what is
/// painted are antialiased over one texel. Where `repeat` is set, what leaves at the right comes in at the left.
class Canvas {
 public:
  Canvas(float width_m, float height_m, int width, int height, bool repeat = false);

  float width_m() const { return width_m_; }
  float height_m() const { return height_m_; }

  /// Sets every texel to f(x, y), in metres.
  template <typename F>
  void fill(const F& f) {
    modify([&](float x, float y, float) { return f(x, y); });
  }
  /// Changes every texel by f(x, y, value).
  template <typename F>
  void modify(const F& f) {
    for (int j = 0; j < height_; ++j)
      for (int i = 0; i < width_; ++i) at(i, j) = f(centre_x(i), centre_y(j), at(i, j));
  }
  /// Adds f(x, y), evaluated only about every `cell_m` metres and interpolated: for what changes slowly.
  template <typename F>
  void add_smooth(const F& f, float cell_m);
  /// Adds grain of the size of texels, and coarser ones.
  void add_grain(const Grain& grain, float strength, std::uint32_t seed);
  void rectangle(float x0, float y0, float x1, float y1, float value, float opacity = 1);
  void disc(float x, float y, float radius, float value, float opacity = 1, float softness_m = 0);
  void line(float x0, float y0, float x1, float y1, float width, float value, float opacity = 1);
  /// Blends to shade(x, y, value) inside a rectangle.
  void pattern(float x0, float y0, float x1, float y1, const std::function<float(float, float, float)>& shade);
  /// Marks that look like `letters` letters of a sign, of this height, from x to the right.
  void lettering(float x, float y, float height, int letters, float value, Random& random);

  Texture texture() const;

 private:
  float centre_x(int i) const { return (static_cast<float>(i) + 0.5F) / sx_; }
  float centre_y(int j) const { return (static_cast<float>(j) + 0.5F) / sy_; }
  template <typename Coverage>
  void blend(float x0, float y0, float x1, float y1, float value, const Coverage& coverage);
  float& at(int i, int j) {
    return values_[static_cast<std::size_t>(j) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(i)];
  }

  float width_m_, height_m_;
  int width_, height_;
  bool repeat_;
  float sx_, sy_;  ///< texels per metre
  std::vector<float> values_;
};

template <typename F>
void Canvas::add_smooth(const F& f, float cell_m) {
  const int step_x = std::max(static_cast<int>(cell_m * sx_), 1), step_y = std::max(static_cast<int>(cell_m * sy_), 1);
  std::vector<float> upper(static_cast<std::size_t>(width_ / step_x) + 2), lower(upper.size());
  const auto evaluate = [&](int j, std::vector<float>& row) {
    for (std::size_t i = 0; i < row.size(); ++i) row[i] = f(centre_x(static_cast<int>(i) * step_x), centre_y(j));
  };
  evaluate(0, lower);
  for (int j = 0; j < height_; ++j) {
    if (j % step_y == 0) {
      upper.swap(lower);
      evaluate(j + step_y, lower);
    }
    const float b = static_cast<float>(j % step_y) / static_cast<float>(step_y);
    for (int i = 0; i < width_; ++i) {
      const auto k = static_cast<std::size_t>(i / step_x);
      const float a = static_cast<float>(i % step_x) / static_cast<float>(step_x);
      const float top = upper[k] + a * (upper[k + 1] - upper[k]), bottom = lower[k] + a * (lower[k + 1] - lower[k]);
      at(i, j) += top + b * (bottom - top);
    }
  }
}

}  // namespace pavo::synthetic
