// The sums over a block, and what the reference image shows of it, against the same in double precision, pixel by
// pixel.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

#include "stages/ground/ground_block.h"

namespace pavo {
namespace {

GroundImage::Level noise(int width, int height, std::uint32_t seed) {
  std::mt19937 random(seed);
  GroundImage::Level level{.width = width, .height = height, .pixels = {}};
  for (int i = 0; i < width * height; ++i) level.pixels.push_back(static_cast<std::uint16_t>(random() % 4081));
  return level;
}

double at(const GroundImage::Level& image, double u, double v) {
  const int x = static_cast<int>(std::floor(u)), y = static_cast<int>(std::floor(v));
  const double a = u - x, b = v - y;
  const auto pixel = [&](int dx, int dy) { return static_cast<double>(image.row(y + dy)[x + dx]); };
  return (1 - b) * ((1 - a) * pixel(0, 0) + a * pixel(1, 0)) + b * ((1 - a) * pixel(0, 1) + a * pixel(1, 1));
}

// Straight lines stay straight and equal steps equal, so that nothing is approximated: a zoom, a turn and a shift.
Eigen::Matrix3d motion() {
  Eigen::Matrix3d H;
  H << 0.97, 0.04, 3.3, -0.03, 0.96, 2.6, 0, 0, 1;
  return H;
}

TEST(Blocks, AreComparedAsInDoublePrecision) {
  const Eigen::Matrix3d H = motion();
  for (int level = 0; level < GroundImage::kLevels; ++level) {
    const BlockSize size = block_size(level);
    const GroundImage::Level current = noise(90, 40, 1), reference = noise(100, 50, 2);
    AlignGround::Block block;
    block.x = 21, block.y = 9;
    ASSERT_TRUE(compare_block(current, reference, size, H, block));
    double sx = 0, sy = 0, sr = 0, rr = 0, bx = 0, by = 0;
    for (int y = block.y; y < block.y + size.height; ++y)
      for (int x = block.x; x < block.x + size.width; ++x) {
        const Eigen::Vector3d p = H * Eigen::Vector3d(x, y, 1);
        const double r = at(reference, p.x(), p.y()) - current.row(y)[x];
        const double gx = 0.5 * (current.row(y)[x + 1] - current.row(y)[x - 1]);
        const double gy = 0.5 * (current.row(y + 1)[x] - current.row(y - 1)[x]);
        sx += gx, sy += gy, sr += r, rr += r * r, bx += gx * r, by += gy * r;
      }
    const double n = size.width * size.height;
    EXPECT_NEAR(block.squared, (rr - sr * sr / n) / n, 1e-4 * rr / n);
    EXPECT_NEAR(block.bx, bx - sx * sr / n, 1e-4 * rr);
    EXPECT_NEAR(block.by, by - sy * sr / n, 1e-4 * rr);
  }
}

TEST(Blocks, ThatLeaveTheReferenceImageAreNotSeen) {
  const GroundImage::Level current = noise(90, 40, 1), reference = noise(100, 50, 2);
  AlignGround::Block block;
  block.x = 21, block.y = 9;
  for (const auto& [dx, dy] : {std::pair{-30.0, 0.0}, {60.0, 0.0}, {0.0, -15.0}, {0.0, 40.0}}) {
    Eigen::Matrix3d H = Eigen::Matrix3d::Identity();
    H(0, 2) = dx, H(1, 2) = dy;
    EXPECT_FALSE(compare_block(current, reference, block_size(0), H, block)) << dx << " " << dy;
  }
  Eigen::Matrix3d behind = Eigen::Matrix3d::Identity();
  behind(2, 2) = -1;
  EXPECT_FALSE(compare_block(current, reference, block_size(0), behind, block));
}

}  // namespace
}  // namespace pavo
