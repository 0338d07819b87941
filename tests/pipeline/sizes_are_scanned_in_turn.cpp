// Which of the people's sizes a frame is searched for goes by its place in the order of admission.
#include <gtest/gtest.h>

#include <random>

#include "drivers/models/model_file.h"
#include "pavo/late_scan.h"

namespace pavo::test {
namespace {

Image noise(int width, int height) {
  Image image;
  image.resize(width, height);
  std::mt19937 random(3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image.row(y)[x] = static_cast<std::uint8_t>(random());
  return image;
}

TEST(ScanUnlessLate, ScansHalfOfTheSizesInTurn) {
  const Image image = noise(160, 200);
  const ScanPeople scan(default_pedestrian_model(), {.threshold = 0, .largest_share = 2});
  Detections even, odd, all, found;
  ScanPeople::Scratch scratch;
  scan(image, std::nullopt, ScanLevels::even, even, scratch);
  scan(image, std::nullopt, ScanLevels::odd, odd, scratch);
  scan(image, std::nullopt, ScanLevels::all, all, scratch);
  ASSERT_NE(even.size(), odd.size());
  bool scanned = false;
  const ScanUnlessLate in_turn{scan, true}, whole{scan, false};
  for (std::uint64_t frame = 0; frame < 4; ++frame) {
    in_turn({.sequence = frame}, image, found, scanned, scratch);
    EXPECT_EQ(found.size(), (frame % 2 == 0 ? even : odd).size()) << frame;
    EXPECT_TRUE(scanned);
    whole({.sequence = frame}, image, found, scanned, scratch);
    EXPECT_EQ(found.size(), all.size()) << frame;
  }
}

}  // namespace
}  // namespace pavo::test
