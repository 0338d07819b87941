#include <gtest/gtest.h>

#include "stages/features/extract.h"
#include "tests/features/pictures.h"
#include "tests/support/counted_allocations.h"

namespace pavo::test {
namespace {

/// The aligned buffers come from elsewhere; they are recognised by their addresses.
std::vector<const void*> buffers(const Features& features, const ExtractFeatures::Scratch& scratch) {
  return {features.keypoints.data(),  features.descriptors.get(), scratch.fast.rows.get(),
          scratch.fast.corners.get(), scratch.grid.cells.data(),  scratch.grid.histograms.data(),
          scratch.surf.integral.get()};
}

TEST(Features, AllocateNothingAfterTheFirstFrame) {
  std::vector<Image> frames;
  frames.push_back(image(cv::Mat(120, 200, CV_8U, cv::Scalar(90))));
  for (unsigned seed = 1; seed <= 6; ++seed) frames.push_back(image(street(200, 120, seed)));
  frames.push_back(image(noise(200, 120, 7)));
  for (bool oriented : {false, true}) {
    const ExtractFeatures extract({.max_features = 150, .oriented = oriented}, 200, 120);
    ExtractFeatures::Scratch scratch;
    Features features;
    extract(frames[1], features, scratch);
    const std::vector<const void*> warm = buffers(features, scratch);
    for (const Image& frame : frames) {
      const long before = allocations;
      extract(frame, features, scratch);
      EXPECT_EQ(allocations - before, 0);
      EXPECT_LE(features.size(), 150u);
    }
    EXPECT_EQ(buffers(features, scratch), warm);
  }
}

TEST(Features, AllocateNothingAfterABlackFirstFrame) {
  const Image black = image(cv::Mat(120, 200, CV_8U, cv::Scalar(0))), rich = image(noise(200, 120, 1));
  for (bool oriented : {false, true}) {
    const ExtractFeatures extract({.max_features = 100, .oriented = oriented}, 200, 120);
    ExtractFeatures::Scratch scratch;
    Features features;
    extract(black, features, scratch);
    const std::vector<const void*> warm = buffers(features, scratch);
    const long before = allocations;
    extract(rich, features, scratch);
    EXPECT_EQ(allocations - before, 0);
    EXPECT_EQ(features.size(), 100u);
    EXPECT_EQ(buffers(features, scratch), warm);
  }
}

}  // namespace
}  // namespace pavo::test
