#include <gtest/gtest.h>

#include "bench/people/reference_hog.h"
#include "stages/people/describe.h"
#include "stages/people/hog_rows.h"
#include "stages/people/pyramid.h"
#include "stages/people/window_scores.h"
#include "tests/people/pictures.h"
#include "tests/support/simd_targets.h"

namespace pavo {
namespace {

struct Difference {
  double largest = 0;       // of blocks with a gradient of a gray level per pixel or more
  double largest_weak = 0;  // of the others, where the rounding of votes shows, because the norm scales it up
  double sum = 0;
  int count = 0;
  void add(double d, bool weak) {
    double& of_kind = weak ? largest_weak : largest;
    of_kind = std::max(of_kind, std::abs(d));
    sum += std::abs(d);
    ++count;
  }
  double mean() const { return sum / count; }
};

Difference compare(const Image& image, const hog::Pyramid& pyramid, const hog::Level& level,
                   const hog::Options& options) {
  const test::ReferenceHog reference(test::level_of(image.view(), level, options.tone), options);
  hog::HogRows rows;
  hog::LevelBlocks blocks;
  blocks.compute(pyramid, level, options, rows);
  EXPECT_EQ(blocks.rows(), reference.cells_y() - 1);
  Difference difference;
  for (int y = 0; y < blocks.rows(); ++y)
    for (int x = 0; x + 1 < reference.cells_x(); ++x) {
      const std::vector<double> expected = reference.block(x, y);
      const bool weak = reference.strength(x, y) < 64;
      for (std::size_t f = 0; f < expected.size(); ++f)
        difference.add(
            static_cast<double>(blocks.row(y)[f * blocks.stride() + static_cast<std::size_t>(x)]) - expected[f], weak);
    }
  return difference;
}

TEST(Hog, AgreesWithTheNaiveOneOnEveryTarget) {
  const Image image = test::textured(331, 267, 1);
  for (const std::int64_t target : test::simd_targets()) {
    const test::ForceTarget forced(target);
    for (const hog::Tone tone : {hog::Tone::linear, hog::Tone::square_root}) {
      const hog::Options options{tone, 60, 0.2f, 0.05f};
      hog::Pyramid pyramid;
      pyramid.plan(image.width(), image.height(), 1.17, tone);
      pyramid.load(image.view());
      ASSERT_EQ(pyramid.levels().size(), 5u);
      for (const hog::Level& level : pyramid.levels()) {
        const Difference difference = compare(image, pyramid, level, options);
        EXPECT_LT(difference.largest, 0.04) << hwy::TargetName(target) << " level " << level.width;
        EXPECT_LT(difference.largest_weak, 0.2) << hwy::TargetName(target) << " level " << level.width;
        EXPECT_LT(difference.mean(), 1e-3) << hwy::TargetName(target) << " level " << level.width;
      }
    }
  }
}

TEST(Hog, BlocksAreTheSameOnEveryTarget) {
  const Image image = test::textured(200, 180, 2);
  const hog::Options options;
  hog::Pyramid pyramid;
  pyramid.plan(image.width(), image.height(), 1.3, options.tone);
  std::vector<hog::LevelBlocks> all;
  for (const std::int64_t target : test::simd_targets()) {
    const test::ForceTarget forced(target);
    pyramid.load(image.view());
    hog::HogRows rows;
    all.emplace_back().compute(pyramid, pyramid.levels().back(), options, rows);
    const int columns = pyramid.levels().back().cells_x() - 1;
    for (int y = 0; y < all[0].rows(); ++y)
      for (std::size_t f = 0; f < hog::kBlockSize; ++f)
        for (int x = 0; x < columns; ++x) {
          const std::size_t at = f * all[0].stride() + static_cast<std::size_t>(x);
          ASSERT_NEAR(all.back().row(y)[at], all[0].row(y)[at], 1e-6f) << hwy::TargetName(target);
        }
  }
}

TEST(Hog, TheDenseScoresAreThoseOfTheDescribedWindows) {
  const Image image = test::textured(301, 190, 3);
  const PedestrianModel model = test::random_model(3);
  const hog::DenseWeights weights(model.weights, model.bias);
  hog::Pyramid pyramid;
  pyramid.plan(image.width(), image.height(), 1.1, model.features.tone);
  pyramid.load(image.view());
  std::vector<float> descriptor(hog::kDescriptorSize);
  for (const std::int64_t target : test::simd_targets()) {
    const test::ForceTarget forced(target);
    for (const hog::Level& level : pyramid.levels()) {
      hog::HogRows rows;
      hog::LevelBlocks blocks;
      blocks.compute(pyramid, level, model.features, rows);
      hog::WindowScores scores;
      scores.start(weights, level.windows_x(), level.windows_y());
      int seen = 0;
      for (int row = 0; row < blocks.rows(); ++row) {
        scores.add(blocks.row(row), blocks.stride());
        for (std::size_t x = 0; x < scores.completed().size(); ++x, ++seen) {
          blocks.describe(static_cast<int>(x), scores.completed_row(), descriptor);
          double expected = static_cast<double>(model.bias);
          for (std::size_t i = 0; i < descriptor.size(); ++i)
            expected += static_cast<double>(descriptor[i]) * static_cast<double>(model.weights[i]);
          ASSERT_NEAR(static_cast<double>(scores.completed()[x]), expected, 1e-4);
        }
      }
      EXPECT_EQ(seen, level.windows_x() * level.windows_y());
    }
  }
}

TEST(Hog, ACropIsDescribedAsTheReferenceDoes) {
  const Image crop = test::textured(80, 144, 4);  // a cell to each side, so that nothing of it is the edge
  const hog::Options options;
  hog::Level level;
  level.as_is = true;
  const test::ReferenceHog reference(test::level_of(crop.view(), level, options.tone), options);
  std::vector<float> descriptor(hog::kDescriptorSize);
  hog::CropDescriber describe(options);
  describe(crop, 0, 0, false, descriptor);
  const std::vector<double> expected = reference.window(1, 1);
  for (std::size_t i = 0; i < expected.size(); ++i)
    ASSERT_NEAR(static_cast<double>(descriptor[i]), expected[i], 0.02) << i;
}

TEST(Hog, TheMirrorImageHasTheMirroredDescriptor) {
  const Image crop = test::textured(70, 134, 5);
  std::vector<float> a(hog::kDescriptorSize), b(hog::kDescriptorSize);
  hog::CropDescriber describe({});
  describe(crop, 1, -2, false, a);
  describe(crop, 1, -2, true, b);
  for (int by = 0; by < hog::kBlocksY; ++by)
    for (int bx = 0; bx < hog::kBlocksX; ++bx)
      for (int cell = 0; cell < 4; ++cell)
        for (int bin = 0; bin < hog::kBins; ++bin)
          ASSERT_NEAR(a[hog::descriptor_index(by, bx, cell / 2, cell % 2, bin)],
                      b[hog::descriptor_index(by, 6 - bx, cell / 2, 1 - cell % 2, 8 - bin)], 0.01f);
}

TEST(Hog, FlatPicturesHaveNoFeatures) {
  Image flat(64, 128);
  for (int y = 0; y < 128; ++y) std::fill_n(flat.row(y), 64, std::uint8_t{200});
  std::vector<float> descriptor(hog::kDescriptorSize, 1.0f);
  hog::CropDescriber describe({});
  describe(flat, 0, 0, false, descriptor);
  for (const float v : descriptor) ASSERT_EQ(v, 0.0f);
}

TEST(Hog, RefusesWhatItCannotDescribe) {
  std::vector<float> descriptor(hog::kDescriptorSize);
  hog::CropDescriber describe({});
  EXPECT_THROW(describe(Image(63, 128), 0, 0, false, descriptor), std::invalid_argument);
  EXPECT_THROW(describe(Image(64, 127), 0, 0, false, descriptor), std::invalid_argument);
  EXPECT_THROW(hog::DenseWeights(std::vector<float>(3781), 0), std::invalid_argument);
  hog::Pyramid pyramid;
  EXPECT_THROW(pyramid.plan(100, 200, 1.0, hog::Tone::linear), std::invalid_argument);
  pyramid.plan(100, 200, 1.1, hog::Tone::linear);
  EXPECT_THROW(pyramid.load(Image(100, 201).view()), std::invalid_argument);
}

}  // namespace
}  // namespace pavo
