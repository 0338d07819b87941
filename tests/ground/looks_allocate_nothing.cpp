// After the first looks no memory is asked for.
#include <gtest/gtest.h>

#include "stages/ground/ground_scale.h"
#include "tests/ground/roads.h"
#include "tests/support/counted_allocations.h"

namespace pavo {
namespace {

TEST(GroundScale, AllocatesNothingAfterWarmUp) {
  GroundScaleOptions options;
  options.filter.height_m = 1.5;
  GroundScale scale(roads::camera(), options);
  long before = 0;
  for (int i = 0; i < 16; ++i) {
    const SE3 T = roads::on_the_way(0.6 * i);
    const Image image = roads::Road{}.seen_from(T);
    if (i >= 10) before = test::allocations.load();
    scale.observe(i, image.view(), T, {});
    if (i >= 10) {
      EXPECT_EQ(test::allocations.load(), before);
    }
  }
  EXPECT_TRUE(scale.known());
}

}  // namespace
}  // namespace pavo
