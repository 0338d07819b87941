#include "stages/ground/ground_block.h"

#include <cmath>
#include <cstdint>

namespace pavo {

void measure_texture(const GroundImage::Level& image, BlockSize size, AlignGround::Block& block) {
  float sx = 0, sy = 0, sv = 0, xx = 0, xy = 0, yy = 0, vv = 0;
  for (int y = block.y; y < block.y + size.height; ++y) {
    const std::uint16_t *above = image.row(y - 1), *row = image.row(y), *below = image.row(y + 1);
    for (int x = block.x; x < block.x + size.width; ++x) {
      const float gx = 0.5f * static_cast<float>(row[x + 1] - row[x - 1]);
      const float gy = 0.5f * static_cast<float>(below[x] - above[x]);
      const float v = row[x];
      sx += gx, sy += gy, sv += v, xx += gx * gx, xy += gx * gy, yy += gy * gy, vv += v * v;
    }
  }
  const float n = static_cast<float>(size.width * size.height);
  block.pixels = size.width * size.height;
  block.xx = xx - sx * sx / n;
  block.xy = xy - sx * sy / n;
  block.yy = yy - sy * sy / n;
  block.variance = vv - sv * sv / n;
}

namespace {

// What the reference image has at up to kMost places in a row: four pixels each, and how far in between.
constexpr int kMost = 32;
static_assert(block_size(0).width <= kMost && block_size(1).width <= kMost && block_size(2).width <= kMost);
struct Places {
  alignas(32) std::int32_t upper_left[kMost], upper_right[kMost], lower_left[kMost], lower_right[kMost];
  alignas(32) float fu[kMost], fv[kMost];
};

// Loops that do one thing each: the compiler makes vectors of them, of one loop for all it does not.
void look_up(const GroundImage::Level& image, float u, float v, float du, float dv, int n, Places& places) {
  alignas(32) float us[kMost], vs[kMost];
  alignas(32) std::int32_t at[kMost];
  for (int i = 0; i < n; ++i, u += du, v += dv) us[i] = u, vs[i] = v;
  for (int i = 0; i < n; ++i) {
    const int iu = static_cast<int>(us[i]), iv = static_cast<int>(vs[i]);
    places.fu[i] = us[i] - static_cast<float>(iu), places.fv[i] = vs[i] - static_cast<float>(iv);
    at[i] = iv * image.width + iu;
  }
  for (int i = 0; i < n; ++i) {
    const std::uint16_t *upper = image.pixels.data() + at[i], *lower = upper + image.width;
    places.upper_left[i] = upper[0], places.upper_right[i] = upper[1];
    places.lower_left[i] = lower[0], places.lower_right[i] = lower[1];
  }
}

}  // namespace

bool compare_block(const GroundImage::Level& current, const GroundImage::Level& reference, BlockSize size,
                   const Eigen::Matrix3d& H, AlignGround::Block& block) {
  const float right = static_cast<float>(reference.width - 2), bottom = static_cast<float>(reference.height - 2);
  float sx = 0, sy = 0, sr = 0, rr = 0, bx = 0, by = 0;
  Places at;
  alignas(32) float gx[kMost], gy[kMost], r[kMost];
  for (int y = block.y; y < block.y + size.height; ++y) {
    // A row of the block is a straight line in the reference image; along it a block is short enough for equal steps.
    const Eigen::Vector3d a = H * Eigen::Vector3d(block.x, y, 1),
                          b = H * Eigen::Vector3d(block.x + size.width - 1, y, 1);
    if (!(a.z() > 1e-9 && b.z() > 1e-9)) return false;
    const float u = static_cast<float>(a.x() / a.z()), v = static_cast<float>(a.y() / a.z());
    const float u1 = static_cast<float>(b.x() / b.z()), v1 = static_cast<float>(b.y() / b.z());
    if (!(u >= 0 && v >= 0 && u <= right && v <= bottom && u1 >= 0 && v1 >= 0 && u1 <= right && v1 <= bottom))
      return false;
    const float du = (u1 - u) / static_cast<float>(size.width - 1), dv = (v1 - v) / static_cast<float>(size.width - 1);
    look_up(reference, u, v, du, dv, size.width, at);
    const std::uint16_t* row = current.row(y) + block.x;
    const std::uint16_t *above = row - current.width, *below = row + current.width;
    for (int i = 0; i < size.width; ++i) {
      const float top =
          static_cast<float>(at.upper_left[i]) + at.fu[i] * static_cast<float>(at.upper_right[i] - at.upper_left[i]);
      const float low =
          static_cast<float>(at.lower_left[i]) + at.fu[i] * static_cast<float>(at.lower_right[i] - at.lower_left[i]);
      r[i] = top + at.fv[i] * (low - top) - static_cast<float>(row[i]);
      gx[i] = 0.5f * static_cast<float>(row[i + 1] - row[i - 1]);
      gy[i] = 0.5f * static_cast<float>(below[i] - above[i]);
    }
    for (int i = 0; i < size.width; ++i)
      sx += gx[i], sy += gy[i], sr += r[i], rr += r[i] * r[i], bx += gx[i] * r[i], by += gy[i] * r[i];
  }
  const float n = static_cast<float>(size.width * size.height);
  block.bx = bx - sx * sr / n;
  block.by = by - sy * sr / n;
  block.squared = (rr - sr * sr / n) / n;
  return true;
}

}  // namespace pavo
