#include <gtest/gtest.h>

#include "tests/pose/worlds.h"
#include "tests/support/counted_allocations.h"

namespace pavo::test {
namespace {

TEST(OdometryMemory, IsAllocatedOnceForTheLargestFrame) {
  const World world(1);
  const std::vector<SE3> path = drive(12);
  std::vector<Features> features;
  std::vector<Image> images;
  for (std::size_t i = 0; i < path.size(); ++i) {
    features.push_back(world.seen_from(path[i], static_cast<std::int64_t>(i)));
    images.emplace_back(kCamera.width, kCamera.height);
  }
  const People people{{300, 100, 60, 150, 1}};
  Odometry odometry(kCamera, {}, true_steps(path));
  PoseResult result;
  long before = 0;
  for (std::size_t round = 0; round < 2; ++round) {
    before = allocations.load();
    for (std::size_t i = 0; i < path.size(); ++i) {
      const FrameTime now = at(static_cast<std::int64_t>(round * path.size() + i));
      const FrameView previous = i > 0 ? FrameView{&features[i - 1], &images[i - 1]} : FrameView{};
      if (i == 5)
        odometry.missed(now, previous, result);
      else
        odometry(now, {&features[i], &images[i]}, i == 6 ? FrameView{} : previous, people, result);
    }
  }
  EXPECT_EQ(allocations.load() - before, 0);
}

}  // namespace
}  // namespace pavo::test
