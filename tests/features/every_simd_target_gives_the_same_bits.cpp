#include <gtest/gtest.h>

#include "stages/features/extract.h"
#include "tests/features/pictures.h"

namespace pavo::test {
namespace {

bool same(const Features& a, const Features& b) {
  const auto equal = [](const Keypoint& p, const Keypoint& q) {
    return p.x == q.x && p.y == q.y && p.response == q.response && p.angle_rad == q.angle_rad;
  };
  return std::equal(a.keypoints.begin(), a.keypoints.end(), b.keypoints.begin(), b.keypoints.end(), equal) &&
         std::equal(a.descriptor(0), a.descriptor(a.size()), b.descriptor(0));
}

TEST(EverySimdTarget, GivesTheSameBits) {
  const Image picture = image(street(310, 190, 1));
  for (double size : {9.0, 13.0, 20.0}) {
    for (bool oriented : {false, true}) {
      const ExtractFeatures extract({.max_features = 300, .oriented = oriented, .keypoint_size = size}, 310, 190);
      ExtractFeatures::Scratch scratch;
      Features first;
      on_every_target([&](const std::string& target) {
        Features features;
        extract(picture, features, scratch);
        EXPECT_GT(features.size(), 100u);
        if (first.size() == 0)
          first = std::move(features);
        else
          EXPECT_TRUE(same(first, features)) << target << ", size " << size << (oriented ? ", oriented" : ", upright");
      });
    }
  }
}

}  // namespace
}  // namespace pavo::test
