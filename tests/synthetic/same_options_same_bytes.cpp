#include <gmock/gmock.h>

#include "tests/synthetic/support.h"

namespace pavo {
namespace {

using test::Gray;
using test::render;
using test::small_street;

bool same(const std::vector<Gray>& a, const std::vector<Gray>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i].pixels != b[i].pixels) return false;
  return true;
}

SyntheticOptions busy_street() {
  SyntheticOptions options = small_street(4);
  options.noise_sigma = 2;
  options.companions = 3;
  options.density = 2;
  return options;
}

TEST(SyntheticDeterminism, AnyNumberOfThreadsGivesTheSameBytes) {
  SyntheticOptions options = busy_street();
  const auto one = render(options);
  for (const int threads : {2, 3, 0}) {
    options.threads = threads;
    EXPECT_TRUE(same(one, render(options))) << threads << " threads";
  }
}

TEST(SyntheticDeterminism, WhatWasSkippedDoesNotChangeWhatFollows) {
  const auto all = render(busy_street());
  SyntheticStreet street(busy_street());
  ASSERT_TRUE(street.skip());
  ASSERT_TRUE(street.skip());
  (void)street.people(0);
  EncodedImage image;
  FrameStamp stamp;
  ASSERT_TRUE(street.read(image, stamp));
  EXPECT_EQ(stamp.index, 2);
  EXPECT_EQ(image.bytes, all[2].pixels);
}

TEST(SyntheticDeterminism, AnotherSeedIsAnotherStreet) {
  SyntheticOptions options = small_street(1);
  const auto a = render(options);
  for (const std::uint64_t seed : {2ULL, 1ULL << 40}) {
    options.seed = seed;
    const auto b = render(options);
    int different = 0;
    for (std::size_t i = 0; i < a[0].pixels.size(); ++i) different += std::abs(a[0].pixels[i] - b[0].pixels[i]) > 10;
    EXPECT_GT(different, static_cast<int>(a[0].pixels.size()) / 4) << "seed " << seed;
  }
}

TEST(SyntheticDeterminism, NoiseHasTheSigmaThatWasAskedFor) {
  SyntheticOptions options = small_street(1);
  const auto clean = render(options);
  options.noise_sigma = 4;
  const auto noisy = render(options);
  double sum = 0, squares = 0;
  int n = 0;
  for (std::size_t i = 0; i < clean[0].pixels.size(); ++i) {
    if (clean[0].pixels[i] < 25 || clean[0].pixels[i] > 230) continue;  // clipping
    const double d = noisy[0].pixels[i] - clean[0].pixels[i];
    sum += d;
    squares += d * d;
    ++n;
  }
  ASSERT_GT(n, 5000);
  EXPECT_NEAR(sum / n, 0, 0.2);
  EXPECT_NEAR(std::sqrt(squares / n), 4, 0.3);
}

}  // namespace
}  // namespace pavo
