// Memory is what it was after the first rounds: what bench/endurance shows for 20,000 frames, for a few hundred.
#include <gtest/gtest.h>
#include <malloc.h>

#include <vector>

#include "drivers/synthetic/synthetic_street.h"
#include "pavo/plain_loop.h"
#include "stages/decode/decode.h"

namespace pavo::test {
namespace {

#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
constexpr int kWarm = 120, kLong = 240;  // there is nothing to be read from malloc: only that it runs
#else
constexpr int kWarm = 600, kLong = 1800;
#endif

std::size_t allocated() {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

TEST(LongDrive, AllocatesNothingMore) {
  SyntheticOptions street;
  street.frames = 24;
  street.width = 256, street.height = 80;
  street.people = false;
  SyntheticStreet sequence(street);
  const Decode decode(street.width, street.height);
  Decode::Scratch scratch;
  EncodedImage encoded;
  std::vector<Image> images(static_cast<std::size_t>(street.frames));
  FrameStamp stamp;
  for (Image& image : images) {
    ASSERT_TRUE(sequence.read(encoded, stamp));
    decode(encoded, image, scratch);
  }
  PlainLoop loop(*sequence.info().camera, {}, std::make_shared<UnitStep>());
  std::size_t warm = 0;
  for (int k = 0; k < kLong; ++k) {  // forth and back
    const auto n = static_cast<int>(images.size());
    const int at = k % (2 * n - 2);
    const PoseResult& pose = loop({.index = k, .t_ns = 100'000'000LL * k},
                                  images[static_cast<std::size_t>(at < n ? at : 2 * n - 2 - at)], {});
    ASSERT_TRUE(pose.T_w_c.t.allFinite());
    if (k == kWarm) warm = allocated();
  }
  EXPECT_LT(allocated(), warm + 100'000);
}

}  // namespace
}  // namespace pavo::test
