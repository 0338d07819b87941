// The HOG of stages/people/hog.h, written down once more as plainly as possible: in double precision, pixel by pixel,
// with angles. Slow; what the fast one must agree with.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "stages/people/hog.h"
#include "stages/people/pyramid.h"
#include "types/image.h"

namespace pavo::test {

class Plane {
 public:
  Plane(int width, int height) : width_(width), height_(height), pixels_(static_cast<std::size_t>(width * height)) {}
  int width() const { return width_; }
  int height() const { return height_; }
  double& at(int x, int y) { return pixels_[static_cast<std::size_t>(y * width_ + x)]; }
  /// Beyond the edges, the edge.
  double operator()(int x, int y) const {
    return pixels_[static_cast<std::size_t>(std::clamp(y, 0, height_ - 1) * width_ + std::clamp(x, 0, width_ - 1))];
  }

 private:
  int width_, height_;
  std::vector<double> pixels_;
};

inline Plane toned(const ImageView& image, hog::Tone tone) {
  Plane out(image.width, image.height);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      out.at(x, y) = tone == hog::Tone::linear ? image.at(x, y) : std::sqrt(255.0 * image.at(x, y));
  return out;
}

inline Plane halved(const Plane& in) {
  Plane out(in.width() / 2, in.height() / 2);
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x)
      out.at(x, y) = (in(2 * x, 2 * y) + in(2 * x + 1, 2 * y) + in(2 * x, 2 * y + 1) + in(2 * x + 1, 2 * y + 1)) / 4;
  return out;
}

/// The width of the triangle such that it and the halvings before have the variance kBlur, in px of the level.
inline double triangle(double step, int octave) {
  double variance = 0;
  for (int k = 0; k < octave; ++k) variance = variance / 4 + 0.0625;
  return std::clamp(std::sqrt(std::max(0.0, 6 * (hog::kBlur * step * step - variance))), 1.0, 2.0);
}

inline Plane level_of(const ImageView& image, const hog::Level& level, hog::Tone tone) {
  Plane source = toned(image, tone);
  if (level.as_is) return source;
  const int octave = static_cast<int>(std::lround(std::log2(level.step_x)));
  for (int k = 0; k < octave; ++k) source = halved(source);
  const double step_x = level.step_x / (1 << octave), step_y = level.step_y / (1 << octave);
  const double wide = triangle(step_x, octave), high = triangle(step_y, octave);
  Plane out(level.width, level.height);
  for (int y = 0; y < level.height; ++y)
    for (int x = 0; x < level.width; ++x) {
      const double cx = (x - level.border + 0.5) * step_x - 0.5, cy = (y - level.border + 0.5) * step_y - 0.5;
      double sum = 0, weights = 0;
      for (int v = static_cast<int>(std::floor(cy)) - 3; v <= cy + 3; ++v)
        for (int u = static_cast<int>(std::floor(cx)) - 3; u <= cx + 3; ++u) {
          const double w = std::max(0.0, wide - std::abs(u - cx)) * std::max(0.0, high - std::abs(v - cy));
          sum += w * source(u, v);
          weights += w;
        }
      out.at(x, y) = sum / weights;
    }
  return out;
}

/// The cells of a level, then its blocks, in gray levels.
class ReferenceHog {
 public:
  ReferenceHog(const Plane& level, const hog::Options& options)
      : cells_x_(level.width() / hog::kCell),
        cells_y_(level.height() / hog::kCell),
        options_(options),
        cells_(static_cast<std::size_t>(cells_x_ * cells_y_ * hog::kBins)) {
    const int half = hog::kCell / 2;
    for (int y = -half; y < cells_y_ * hog::kCell + half; ++y)
      for (int x = -half; x < cells_x_ * hog::kCell + half; ++x) vote(level, x, y);
  }

  int cells_x() const { return cells_x_; }
  int cells_y() const { return cells_y_; }

  /// The block whose upper left cell is (x, y): 36 numbers, cell by rows, then bin.
  std::vector<double> block(int x, int y) const {
    std::vector<double> b;
    for (int dy = 0; dy < 2; ++dy)
      for (int dx = 0; dx < 2; ++dx)
        for (int bin = 0; bin < hog::kBins; ++bin) b.push_back(cell(x + dx, y + dy, bin));
    scale(b, 1 / (norm(b) + static_cast<double>(options_.epsilon)));
    for (double& v : b) v = std::min(v, static_cast<double>(options_.clip));
    scale(b, 1 / (norm(b) + static_cast<double>(options_.fade)));
    return b;
  }

  /// How much gradient the block has, in gray levels summed over its cells.
  double strength(int x, int y) const {
    std::vector<double> b;
    for (int dy = 0; dy < 2; ++dy)
      for (int dx = 0; dx < 2; ++dx)
        for (int bin = 0; bin < hog::kBins; ++bin) b.push_back(cell(x + dx, y + dy, bin));
    return norm(b);
  }

  /// The descriptor of the window whose upper left cell is (x, y).
  std::vector<double> window(int x, int y) const {
    std::vector<double> d;
    for (int by = 0; by < hog::kBlocksY; ++by)
      for (int bx = 0; bx < hog::kBlocksX; ++bx) {
        const std::vector<double> b = block(x + bx, y + by);
        d.insert(d.end(), b.begin(), b.end());
      }
    return d;
  }

 private:
  static double norm(const std::vector<double>& b) {
    double sum = 0;
    for (const double v : b) sum += v * v;
    return std::sqrt(sum);
  }
  static void scale(std::vector<double>& b, double factor) {
    for (double& v : b) v *= factor;
  }
  double cell(int x, int y, int bin) const {
    return cells_[static_cast<std::size_t>((y * cells_x_ + x) * hog::kBins + bin)];
  }

  void vote(const Plane& level, int x, int y) {
    const double gx = level(x + 1, y) - level(x - 1, y), gy = level(x, y + 1) - level(x, y - 1);
    const double size = std::hypot(gx, gy);
    if (size == 0) return;
    const double step = std::numbers::pi / hog::kBins;
    double angle = std::atan2(gy, gx);
    if (angle < 0) angle += std::numbers::pi;  // unsigned
    const double position = angle / step - 0.5;
    const int bin = static_cast<int>(std::floor(position));
    const double beyond = (position - bin) * step;
    // The coordinates of the gradient in the basis of the two directions beside it.
    add(x, y, (bin + hog::kBins) % hog::kBins, size * std::sin(step - beyond) / std::sin(step));
    add(x, y, (bin + 1) % hog::kBins, size * std::sin(beyond) / std::sin(step));
  }

  void add(int x, int y, int bin, double vote) {
    for (int cy = 0; cy < cells_y_; ++cy) {
      const double wy = 1 - std::abs(y - (cy * 8 + 3.5)) / 8;
      if (wy <= 0) continue;
      for (int cx = std::max(0, (x - 12) / 8 - 1); cx < std::min(cells_x_, x / 8 + 3); ++cx) {
        const double wx = 1 - std::abs(x - (cx * 8 + 3.5)) / 8;
        if (wx > 0) cells_[static_cast<std::size_t>((cy * cells_x_ + cx) * hog::kBins + bin)] += wx * wy * vote;
      }
    }
  }

  int cells_x_, cells_y_;
  hog::Options options_;
  std::vector<double> cells_;
};

}  // namespace pavo::test
