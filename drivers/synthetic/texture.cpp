#include "drivers/synthetic/texture.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace pavo::synthetic {
namespace {

constexpr float kMaxAnisotropy = 16;

/// log2 with the mantissa taken as linear: continuous, monotonic, off by at most 0.09, which no eye sees in a mip
/// level.
float coarse_log2(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  return static_cast<float>(bits) * 0x1p-23F - 127.0F;
}

int floor_to_int(float x) {
  const int i = static_cast<int>(x);
  return i - static_cast<int>(x < static_cast<float>(i));
}

}  // namespace

Texture::Texture(int width, int height, std::vector<std::uint8_t> texels, bool repeat_u) : repeat_u_(repeat_u) {
  levels_.push_back({width, height, std::move(texels)});
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    const Level& fine = levels_.back();
    Level coarse{std::max(fine.width / 2, 1), std::max(fine.height / 2, 1), {}};
    coarse.texels.resize(static_cast<std::size_t>(coarse.width) * static_cast<std::size_t>(coarse.height));
    for (int y = 0; y < coarse.height; ++y) {
      const int y0 = std::min(2 * y, fine.height - 1), y1 = std::min(2 * y + 1, fine.height - 1);
      for (int x = 0; x < coarse.width; ++x) {
        const int x0 = std::min(2 * x, fine.width - 1), x1 = std::min(2 * x + 1, fine.width - 1);
        const auto at = [&](int i, int j) {
          return static_cast<int>(fine.texels[static_cast<std::size_t>(j * fine.width + i)]);
        };
        coarse.texels[static_cast<std::size_t>(y * coarse.width + x)] =
            static_cast<std::uint8_t>((at(x0, y0) + at(x1, y0) + at(x0, y1) + at(x1, y1) + 2) / 4);
      }
    }
    levels_.push_back(std::move(coarse));
  }
}

float Texture::bilinear(const Level& level, float u, float v) const {
  const float x = u - 0.5F, y = v - 0.5F;
  int x0 = floor_to_int(x), y0 = floor_to_int(y);
  const float a = x - static_cast<float>(x0), b = y - static_cast<float>(y0);
  int x1 = x0 + 1, y1 = y0 + 1;
  if (repeat_u_) {
    x0 &= level.width - 1;
    x1 &= level.width - 1;
  } else {
    x0 = std::clamp(x0, 0, level.width - 1);
    x1 = std::clamp(x1, 0, level.width - 1);
  }
  y0 = std::clamp(y0, 0, level.height - 1);
  y1 = std::clamp(y1, 0, level.height - 1);
  const std::uint8_t* top = level.texels.data() + static_cast<std::ptrdiff_t>(y0) * level.width;
  const std::uint8_t* bottom = level.texels.data() + static_cast<std::ptrdiff_t>(y1) * level.width;
  const float t = static_cast<float>(top[x0]) + a * static_cast<float>(top[x1] - top[x0]);
  const float s = static_cast<float>(bottom[x0]) + a * static_cast<float>(bottom[x1] - bottom[x0]);
  return t + b * (s - t);
}

float Texture::tap(float u, float v, float lod) const {
  const float last = static_cast<float>(levels_.size() - 1);
  if (lod <= 0) return bilinear(levels_[0], u, v);
  if (lod >= last) return bilinear(levels_.back(), 0.5F, 0.5F);
  const int k = static_cast<int>(lod);
  const float scale = std::bit_cast<float>(static_cast<std::uint32_t>(127 - k) << 23);  // 2^-k
  const float fine = bilinear(levels_[static_cast<std::size_t>(k)], u * scale, v * scale);
  const float coarse = bilinear(levels_[static_cast<std::size_t>(k + 1)], u * scale * 0.5F, v * scale * 0.5F);
  return fine + (lod - static_cast<float>(k)) * (coarse - fine);
}

float Texture::sample(float u, float v, float size) const {
  return tap(u, v, coarse_log2(std::max(size, 1e-6F)));
}

float Texture::sample(float u, float v, const Footprint& f) const {
  const float xx = f.du_dx * f.du_dx + f.dv_dx * f.dv_dx, yy = f.du_dy * f.du_dy + f.dv_dy * f.dv_dy;
  const float along_u = xx > yy ? f.du_dx : f.du_dy, along_v = xx > yy ? f.dv_dx : f.dv_dy;
  const float major = std::max(std::sqrt(std::max(xx, yy)), 1e-6F);
  const float area = std::abs(f.du_dx * f.dv_dy - f.dv_dx * f.du_dy);
  const float minor = std::max({area / major, major / kMaxAnisotropy, 1e-6F});
  const float lod = coarse_log2(minor);
  // below one texel bilinear interpolation is wide enough by itself
  const int taps = std::min(1 + static_cast<int>(major / std::max(minor, 1.0F)), static_cast<int>(kMaxAnisotropy));
  if (taps == 1) return tap(u, v, lod);
  const float step = 1.0F / static_cast<float>(taps);
  float sum = 0, at = 0.5F * step - 0.5F;
  for (int i = 0; i < taps; ++i, at += step) sum += tap(u + at * along_u, v + at * along_v, lod);
  return sum * step;
}

}  // namespace pavo::synthetic
