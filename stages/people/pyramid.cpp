#include "stages/people/pyramid.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "stages/people/hog_cells.h"
#include "stages/people/resample.h"

namespace pavo::hog {
namespace {

constexpr std::size_t kSlack = 64;  // numbers that may be read or written beyond a row's last pixel

std::size_t padded(int width) {
  return (static_cast<std::size_t>(width) + 2 * kSlack - 1) / kSlack * kSlack;
}

/// The variance, in px^2 of the halved image, of halving the image `octave` times: each is a box of two pixels.
double variance_of_halving(int octave) {
  double variance = 0;
  for (int k = 0; k < octave; ++k) variance = variance / 4 + 1.0 / 16;
  return variance;
}

/// Half the width of the triangle, in px of the halved image, that brings a level `step` times smaller to kBlur. A
/// triangle has the variance half_width^2 / 6; four neighbours reach as far as 2, and below 1 some would be skipped.
double half_width(double step, int octave) {
  const double variance = kBlur * step * step - variance_of_halving(octave);
  return std::clamp(std::sqrt(std::max(0.0, 6 * variance)), 1.0, 2.0);
}

/// Pixel i of a level `step` times smaller, from a line of `size` pixels (at least 4), which goes on with its end
/// pixels.
Taps taps_for(int i, double step, double half_width, int size) {
  const double center = (i + 0.5) * step - 0.5;
  const int first = static_cast<int>(std::floor(center - half_width)) + 1;
  double weights[4], sum = 0;
  for (int k = 0; k < 4; ++k) sum += weights[k] = std::max(0.0, half_width - std::abs(first + k - center));
  Taps taps;
  taps.first = std::clamp(first, 0, size - 4);
  int left = 16384;
  for (int k = 3; k >= 0; --k) {
    const int at = std::clamp(first + k, 0, size - 1) - taps.first;
    const int weight = k == 0 ? left : static_cast<int>(std::lrint(16384 * weights[k] / sum));
    taps.weights[at] = static_cast<std::int16_t>(taps.weights[at] + weight);
    left -= weight;
  }
  return taps;
}

std::int32_t pair(std::int16_t low, std::int16_t high) {
  return low | (high << 16);
}

}  // namespace

void Pyramid::plan(int width, int height, double step, Tone tone, Sampling sampling, int border) {
  if (!(step > 1)) throw std::invalid_argument("hog: the step from level to level must be larger than 1");
  if (border < 0) throw std::invalid_argument("hog: the border must not be negative");
  if (width == width_ && height == height_ && border == border_ && step == step_ && tone == tone_ &&
      sampling == sampling_)
    return;
  width_ = width;
  height_ = height;
  border_ = border;
  step_ = step;
  tone_ = tone;
  sampling_ = sampling;
  toned_.resize(256);
  for (std::size_t i = 0; i < 256; ++i) {
    const double gray = static_cast<double>(i) / 255;
    toned_[i] =
        static_cast<std::int16_t>(std::lround(kPixelMax * (tone == Tone::square_root ? std::sqrt(gray) : gray)));
  }
  planes_.clear();
  levels_.clear();
  for (double scale = 1;; scale *= step) {
    const auto fits = [&](int size, int window) {
      return std::lrint(size / scale) >= std::max(window - 2 * border_, window / 2);
    };
    if (!fits(width_, kWindowWidth) || !fits(height_, kWindowHeight)) break;
    plan_level(scale);
  }
}

void Pyramid::plan_planes(int octave) {
  for (int k = static_cast<int>(planes_.size()); k <= octave; ++k) {
    Plane plane;
    plane.width = width_ >> k;
    plane.height = height_ >> k;
    plane.stride = padded(plane.width);
    plane.pixels.assign(plane.stride * static_cast<std::size_t>(plane.height), 0);
    planes_.push_back(std::move(plane));
  }
}

void Pyramid::plan_level(double scale) {
  Level level;
  const auto width = static_cast<int>(std::lrint(width_ / scale));
  const auto height = static_cast<int>(std::lrint(height_ / scale));
  level.width = width + 2 * border_;
  level.height = height + 2 * border_;
  level.border = border_;
  level.step_x = static_cast<double>(width_) / width;
  level.step_y = static_cast<double>(height_) / height;
  level.octave = static_cast<int>(std::lround(std::log2(scale)));
  level.as_is = sampling_ == Sampling::as_is && scale == 1;
  plan_planes(level.octave);

  const Plane& plane = planes_[static_cast<std::size_t>(level.octave)];
  const double step_x = level.step_x / (1 << level.octave), step_y = level.step_y / (1 << level.octave);
  // Two margins hold the group of columns beyond the last cell; the slack is never looked at, but read.
  const std::size_t size = padded(level.cells_x() * kCell + 2 * Level::kMargin);
  level.offsets.resize(size);
  level.weights01.resize(size);
  level.weights23.resize(size);
  for (std::size_t i = 0; i < size; ++i) {
    const int x = std::clamp(static_cast<int>(i) - Level::kMargin, 0, level.width - 1);
    const Taps taps = taps_for(x - border_, step_x, half_width(step_x, level.octave), plane.width);
    level.offsets[i] = taps.first;
    level.weights01[i] = pair(taps.weights[0], taps.weights[1]);
    level.weights23[i] = pair(taps.weights[2], taps.weights[3]);
  }
  for (int y = 0; y < level.height; ++y)
    level.rows.push_back(taps_for(y - border_, step_y, half_width(step_y, level.octave), plane.height));
  levels_.push_back(std::move(level));
}

void Pyramid::load(const ImageView& image) {
  if (planes_.empty()) return;
  if (image.width != width_ || image.height != height_)
    throw std::invalid_argument("hog: the image is not of the size that was planned");
  tone(image);
  for (std::size_t k = 1; k < planes_.size(); ++k) {
    const Plane& from = planes_[k - 1];
    Plane& to = planes_[k];
    for (std::size_t y = 0; y < static_cast<std::size_t>(to.height); ++y) {
      const std::int16_t* above = from.pixels.data() + 2 * y * from.stride;
      halve_rows(above, above + from.stride, to.width, to.pixels.data() + y * to.stride);
    }
  }
}

void Pyramid::tone(const ImageView& image) {
  Plane& plane = planes_[0];
  for (int y = 0; y < height_; ++y) {
    const std::uint8_t* in = image.row(y);
    std::int16_t* out = plane.pixels.data() + plane.stride * static_cast<std::size_t>(y);
    for (int x = 0; x < width_; ++x) out[x] = toned_[in[x]];
  }
}

void Pyramid::row(const Level& level, int y, std::int16_t* out, std::int16_t* blended) const {
  const Plane& plane = planes_[static_cast<std::size_t>(level.octave)];
  y = std::clamp(y, 0, level.height - 1);
  if (level.as_is) {
    const std::int16_t* from = plane.pixels.data() + plane.stride * static_cast<std::size_t>(y);
    for (int i = 0; i < static_cast<int>(row_size(level)); ++i)
      out[i] = from[std::clamp(i - Level::kMargin, 0, level.width - 1)];
    return;
  }
  const Taps& taps = level.rows[static_cast<std::size_t>(y)];
  blend_rows(plane.pixels.data() + plane.stride * static_cast<std::size_t>(taps.first), plane.stride, taps.weights,
             plane.width, blended);
  sample_row(blended, level.offsets.data(), level.weights01.data(), level.weights23.data(),
             level.cells_x() * kCell + 2 * Level::kMargin, out);
}

}  // namespace pavo::hog
