#include "stages/ground/ground_block.h"

#include <cmath>

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

bool compare_block(const GroundImage::Level& current, const GroundImage::Level& reference, BlockSize size,
                   const Eigen::Matrix3d& H, AlignGround::Block& block) {
  const float right = static_cast<float>(reference.width - 2), bottom = static_cast<float>(reference.height - 2);
  float sx = 0, sy = 0, sr = 0, rr = 0, bx = 0, by = 0;
  for (int y = block.y; y < block.y + size.height; ++y) {
    // A row of the block is a straight line in the reference image; along it a block is short enough for equal steps.
    const Eigen::Vector3d a = H * Eigen::Vector3d(block.x, y, 1),
                          b = H * Eigen::Vector3d(block.x + size.width - 1, y, 1);
    if (!(a.z() > 1e-9 && b.z() > 1e-9)) return false;
    float u = static_cast<float>(a.x() / a.z()), v = static_cast<float>(a.y() / a.z());
    const float u1 = static_cast<float>(b.x() / b.z()), v1 = static_cast<float>(b.y() / b.z());
    if (!(u >= 0 && v >= 0 && u <= right && v <= bottom && u1 >= 0 && v1 >= 0 && u1 <= right && v1 <= bottom))
      return false;
    const float du = (u1 - u) / static_cast<float>(size.width - 1), dv = (v1 - v) / static_cast<float>(size.width - 1);
    const std::uint16_t *above = current.row(y - 1), *row = current.row(y), *below = current.row(y + 1);
    for (int x = block.x; x < block.x + size.width; ++x, u += du, v += dv) {
      const int iu = static_cast<int>(u), iv = static_cast<int>(v);
      const float fu = u - static_cast<float>(iu), fv = v - static_cast<float>(iv);
      const std::uint16_t *p = reference.row(iv) + iu, *q = p + reference.width;
      const float top = p[0] + fu * static_cast<float>(p[1] - p[0]), low = q[0] + fu * static_cast<float>(q[1] - q[0]);
      const float r = top + fv * (low - top) - row[x];
      const float gx = 0.5f * static_cast<float>(row[x + 1] - row[x - 1]);
      const float gy = 0.5f * static_cast<float>(below[x] - above[x]);
      sx += gx, sy += gy, sr += r, rr += r * r, bx += gx * r, by += gy * r;
    }
  }
  const float n = static_cast<float>(size.width * size.height);
  block.bx = bx - sx * sr / n;
  block.by = by - sy * sr / n;
  block.squared = (rr - sr * sr / n) / n;
  return true;
}

}  // namespace pavo
