#include <gtest/gtest.h>

#include <cmath>

#include "stages/matches/refine_subpixel.h"
#include "stages/pose/random.h"
#include "tests/support/simd_targets.h"

namespace pavo::test {
namespace {

// A smooth texture, shifted by (dx, dy), brighter by `bias`.
Image texture(float dx, float dy, float bias = 0) {
  Image image(160, 120);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) {
      const float u = static_cast<float>(x) - dx, v = static_cast<float>(y) - dy;
      const float value = 120 + 40 * std::sin(0.35f * u + 0.1f * v) + 35 * std::sin(0.3f * v - 0.15f * u + 1) +
                          15 * std::sin(0.7f * u) * std::cos(0.6f * v);
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(value * 0.8f + bias));
    }
  return image;
}

TEST(Subpixel, FindsTheShiftOnEveryTarget) {
  const Image previous = texture(0, 0);
  for (const std::int64_t target : simd_targets()) {
    const ForceTarget force(target);
    for (const float bias : {0.0f, 20.0f}) {
      const Image current = texture(3.3f, -2.4f, bias);
      PointPairs pairs;
      for (int y = 30; y < 90; y += 15)
        for (int x = 30; x < 130; x += 20) {
          const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
          pairs.push_back({fx, fy, fx + 3, fy - 2});
        }
      std::vector<std::uint8_t> refined(pairs.size());
      EXPECT_EQ(RefineSubpixel()(previous.view(), current.view(), pairs, refined), static_cast<int>(pairs.size()));
      for (const PointPair& pair : pairs) {
        EXPECT_NEAR(pair.x_current - pair.x_previous, 3.3, 0.05) << hwy::TargetName(target);
        EXPECT_NEAR(pair.y_current - pair.y_previous, -2.4, 0.05) << hwy::TargetName(target);
      }
    }
  }
}

TEST(Subpixel, LeavesAloneWhatItCannotRefine) {
  const Image previous = texture(0, 0);
  Image flat(160, 120);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) flat.at(x, y) = 90;
  const PointPairs before{{3, 60, 3, 60}, {159, 119, 80, 60}, {80, 60, 0, 0}, {80, 60, 110, 40}};
  PointPairs pairs = before;
  std::vector<std::uint8_t> refined(pairs.size());
  EXPECT_EQ(RefineSubpixel()(flat.view(), flat.view(), pairs, refined), 0);
  for (std::size_t i = 0; i < 3; ++i) {
    PointPairs one{before[i]};
    std::vector<std::uint8_t> flag(1);
    EXPECT_EQ(RefineSubpixel()(previous.view(), previous.view(), one, flag), 0) << i;
    EXPECT_EQ(one[0].x_current, before[i].x_current);
    EXPECT_EQ(one[0].y_current, before[i].y_current);
  }
}

TEST(Subpixel, RefusesWhatDoesNotGoTogether) {
  const Image a(160, 120), b(100, 120);
  PointPairs pairs(2);
  std::vector<std::uint8_t> one(1), two(2);
  EXPECT_THROW(RefineSubpixel()(a.view(), b.view(), pairs, two), std::invalid_argument);
  EXPECT_THROW(RefineSubpixel()(a.view(), a.view(), pairs, one), std::invalid_argument);
}

}  // namespace
}  // namespace pavo::test
