#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

#include "drivers/synthetic/parallel.h"

namespace pavo::synthetic {
namespace {

TEST(SyntheticLoops, DoEveryPieceOnce) {
  for (const int threads : {0, 1, 2, 5}) {
    for (const int count : {0, 1, 3, 100}) {
      std::vector<std::atomic<int>> done(static_cast<std::size_t>(count));
      for_each_index(count, threads, [&](int i) { ++done[static_cast<std::size_t>(i)]; });
      for (const auto& times : done) EXPECT_EQ(times, 1) << threads << " threads, " << count << " pieces";
    }
  }
}

TEST(SyntheticLoops, HandOnWhatAPieceThrows) {
  for (const int threads : {1, 4}) {
    const auto run = [&] {
      for_each_index(50, threads, [](int i) {
        if (i == 7) throw std::runtime_error("seven");
      });
    };
    EXPECT_THROW(run(), std::runtime_error) << threads << " threads";
  }
}

}  // namespace
}  // namespace pavo::synthetic
