#include "stages/ground/ground_image.h"

#include <algorithm>

namespace pavo {
namespace {

void smooth_row(const std::uint8_t* in, int width, std::uint16_t* out) {
  for (int x = 1; x + 1 < width; ++x) out[x] = static_cast<std::uint16_t>(in[x - 1] + 2 * in[x] + in[x + 1]);
  out[0] = static_cast<std::uint16_t>(3 * in[0] + in[std::min(1, width - 1)]);
  if (width > 1) out[width - 1] = static_cast<std::uint16_t>(3 * in[width - 1] + in[width - 2]);
}

void halve(const GroundImage::Level& from, GroundImage::Level& to) {
  to.width = from.width / 2;
  to.height = from.height / 2;
  to.pixels.resize(static_cast<std::size_t>(to.width) * to.height);
  for (int y = 0; y < to.height; ++y) {
    const std::uint16_t *a = from.row(2 * y), *b = from.row(2 * y + 1);
    std::uint16_t* out = to.row(y);
    for (int x = 0; x < to.width; ++x)
      out[x] = static_cast<std::uint16_t>((a[2 * x] + a[2 * x + 1] + b[2 * x] + b[2 * x + 1] + 2) / 4);
  }
}

}  // namespace

void GroundImage::assign(const ImageView& image, int top) {
  top_ = std::clamp(top, 0, std::max(0, image.height - 1)) / 4 * 4;
  Level& full = levels_[0];
  full.width = image.width;
  full.height = image.height - top_;
  full.pixels.resize(static_cast<std::size_t>(full.width) * full.height);
  const auto w = static_cast<std::size_t>(full.width);
  rows_.resize(3 * w);
  const auto smoothed = [&](int y) { return rows_.data() + static_cast<std::size_t>((y + 3) % 3) * w; };
  const auto source = [&](int y) { return image.row(std::clamp(top_ + y, 0, image.height - 1)); };
  smooth_row(source(-1), full.width, smoothed(-1));
  smooth_row(source(0), full.width, smoothed(0));
  for (int y = 0; y < full.height; ++y) {
    smooth_row(source(y + 1), full.width, smoothed(y + 1));
    const std::uint16_t *a = smoothed(y - 1), *b = smoothed(y), *c = smoothed(y + 1);
    std::uint16_t* out = full.row(y);
    for (int x = 0; x < full.width; ++x) out[x] = static_cast<std::uint16_t>(a[x] + 2 * b[x] + c[x]);
  }
  for (std::size_t l = 1; l < kLevels; ++l) halve(levels_[l - 1], levels_[l]);
}

Camera camera_of_level(const Camera& camera, int top, int level) {
  const double scale = 1.0 / (1 << level);
  Camera c = camera;
  c.fx *= scale;
  c.fy *= scale;
  c.cx = (camera.cx + 0.5) * scale - 0.5;
  c.cy = (camera.cy - top + 0.5) * scale - 0.5;
  c.width = camera.width >> level;
  c.height = (camera.height - top) >> level;
  return c;
}

}  // namespace pavo
