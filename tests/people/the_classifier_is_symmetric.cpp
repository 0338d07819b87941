#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>

#include "stages/people/describe.h"
#include "stages/people/symmetry.h"
#include "tests/people/pictures.h"

namespace pavo {
namespace {

double margin(std::span<const double> w, std::span<const float> descriptor) {
  return std::inner_product(descriptor.begin(), descriptor.end(), w.begin(), w.back());
}

TEST(Symmetry, AWindowAndItsMirrorImageHaveTheMeanOfTheirMargins) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::vector<double> w(hog::kDescriptorSize + 1);
  for (double& v : w) v = normal(random);
  const std::vector<double> s = symmetric(w);
  hog::CropDescriber describe{hog::Options{}};
  std::vector<float> plain(hog::kDescriptorSize), mirrored(hog::kDescriptorSize);
  for (unsigned seed = 0; seed < 5; ++seed) {
    const Image crop = test::textured(70, 134, seed);
    describe(crop, 0, 0, false, plain);
    describe(crop, 0, 0, true, mirrored);
    ASSERT_GT(std::abs(margin(w, plain) - margin(w, mirrored)), 0.5);
    const double mean = (margin(w, plain) + margin(w, mirrored)) / 2;
    EXPECT_NEAR(margin(s, plain), mean, 0.1);
    EXPECT_NEAR(margin(s, mirrored), mean, 0.1);
  }
  EXPECT_EQ(symmetric(s), s);
}

TEST(Symmetry, RefusesAnotherNumberOfWeights) {
  EXPECT_THROW(symmetric(std::vector<double>(3780)), std::invalid_argument);
}

}  // namespace
}  // namespace pavo
