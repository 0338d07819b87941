#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "stages/matches/align_patch.h"

namespace pavo::test {
namespace {

// A smooth texture, `scale` times as large about (60, 50), shifted, with another brightness and contrast.
Image texture(double scale, double dx, double dy, double gain = 1, double offset = 0) {
  Image image(120, 100);
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 120; ++x) {
      const double u = (x - dx - 60) / scale, v = (y - dy - 50) / scale;
      const double value =
          110 + 40 * std::sin(0.45 * u + 0.2 * v) + 35 * std::cos(0.15 * u - 0.5 * v + 0.3 * u * v / 40);
      image.at(x, y) = static_cast<std::uint8_t>(std::lround(std::min(255.0, std::max(0.0, gain * value + offset))));
    }
  return image;
}

struct Case {
  double scale, dx, dy, gain, offset;
};

class PatchFound : public ::testing::TestWithParam<Case> {};

TEST_P(PatchFound, ToAFractionOfAPixel) {
  const Case& c = GetParam();
  const Image before = texture(1, 0, 0), now = texture(c.scale, c.dx, c.dy, c.gain, c.offset);
  Patch patch;
  ASSERT_TRUE(take_patch(before.view(), 60, 50, patch));
  const Aligned aligned = align_patch(patch, static_cast<float>(c.scale), now.view(), 60, 50, {});
  ASSERT_TRUE(aligned.found);
  EXPECT_NEAR(aligned.x, 60 + c.dx, 0.06);
  EXPECT_NEAR(aligned.y, 50 + c.dy, 0.06);
  EXPECT_GT(aligned.correlation, 0.97);
}

INSTANTIATE_TEST_SUITE_P(Cases, PatchFound,
                         ::testing::Values(Case{1, 0, 0, 1, 0}, Case{1, 1.3, -0.7, 1, 0}, Case{1.2, 0.4, 0.6, 1, 0},
                                           Case{0.85, -0.8, 0.3, 1, 0}, Case{1, 0.5, 0.5, 0.7, 30},
                                           Case{1.1, -1.2, 1.1, 1.2, -15}));

// Waves of all directions about (60, 50): no texture is like another.
class Waves {
 public:
  explicit Waves(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (Wave& wave : waves_) {
      const double k = 0.2 + 0.8 * uniform(random), direction = 2 * std::numbers::pi * uniform(random);
      wave = {k * std::cos(direction), k * std::sin(direction), 2 * std::numbers::pi * uniform(random),
              20 * uniform(random)};
    }
  }
  double operator()(double x, double y) const {
    double value = 120;
    for (const Wave& wave : waves_) value += wave.height * std::sin(wave.kx * (x - 60) + wave.ky * (y - 50) + wave.at);
    return value;
  }
  template <class From>
  Image draw(const From& from) const {
    Image image(120, 100);
    for (int y = 0; y < 100; ++y)
      for (int x = 0; x < 120; ++x)
        image.at(x, y) = static_cast<std::uint8_t>(std::lround(std::clamp(from(*this, x, y), 0.0, 255.0)));
    return image;
  }

 private:
  struct Wave {
    double kx, ky, at, height;
  };
  std::array<Wave, 10> waves_;
};

struct MeanError {
  double x = 0, y = 0, size = 0;
  int found = 0;
};

// Of patches cut out of Waves and looked for in what `now` makes of them, where the point stays.
template <class Now>
MeanError mean_error(const Now& now) {
  MeanError mean;
  for (unsigned seed = 0; seed < 200; ++seed) {
    const Waves waves(seed);
    Patch patch;
    take_patch(waves.draw([](const Waves& w, double x, double y) { return w(x, y); }).view(), 60, 50, patch);
    const Aligned aligned = align_patch(patch, 1, waves.draw(now).view(), 60, 50, {});
    if (!aligned.found) continue;
    ++mean.found;
    mean.x += aligned.x - 60, mean.y += aligned.y - 50;
    mean.size += std::hypot(aligned.x - 60, aligned.y - 50);
  }
  mean.x /= mean.found, mean.y /= mean.found, mean.size /= mean.found;
  return mean;
}

// A wall that comes nearer grows more along the road than it is drawn: on one side of the point as on the other.
TEST(Patch, IsNotFoundToOneSideOfWhatGrowsMore) {
  const MeanError wide = mean_error([](const Waves& w, double x, double y) { return w(60 + (x - 60) / 1.2, y); });
  const MeanError high = mean_error([](const Waves& w, double x, double y) { return w(x, 50 + (y - 50) / 1.2); });
  EXPECT_GT(std::min(wide.found, high.found), 100);
  EXPECT_NEAR(wide.x, 0, 0.03);
  EXPECT_NEAR(wide.y, 0, 0.03);
  EXPECT_NEAR(high.x, 0, 0.03);
  EXPECT_NEAR(high.y, 0, 0.03);
}

// Beyond an edge beside the point is something farther away, which moves less.
TEST(Patch, IsHeldByWhatIsNear) {
  const MeanError edge = mean_error([](const Waves& w, double x, double y) { return w(x + (x > 65 ? 1 : 0), y); });
  EXPECT_GT(edge.found, 100);
  EXPECT_LT(edge.size, 0.1);
}

TEST(Patch, IsNotTakenBeyondTheImage) {
  const Image image = texture(1, 0, 0);
  Patch patch;
  EXPECT_FALSE(take_patch(image.view(), 5, 50, patch));
  EXPECT_FALSE(take_patch(image.view(), 60, 97, patch));
}

TEST(Patch, IsNotFoundWhereNothingIs) {
  const Image image = texture(1, 0, 0);
  Image flat(120, 100);
  for (int y = 0; y < 100; ++y) std::fill_n(flat.row(y), 120, std::uint8_t{90});
  Patch patch, blank;
  ASSERT_TRUE(take_patch(image.view(), 60, 50, patch));
  EXPECT_FALSE(align_patch(patch, 1, flat.view(), 60, 50, {}).found);
  ASSERT_TRUE(take_patch(flat.view(), 60, 50, blank));
  EXPECT_FALSE(align_patch(blank, 1, image.view(), 60, 50, {}).found);
  EXPECT_FALSE(align_patch(patch, 1, image.view(), 2, 50, {}).found);
}

}  // namespace
}  // namespace pavo::test
