// What drivers have been seen to do to frames, stamps and counts.
#include "tests/v4l2/support.h"

namespace pavo::v4l2::test {
namespace {

using ::testing::HasSubstr;

TEST(Frames, AreCopiedRowByRowWithTheirPadding) {
  Played p;
  p.driver.padding = 10;
  p.open();
  Shown shown;
  shown.gray = 77;
  shown.stamp_ns = p.driver.now_ns();
  p.driver.advance(kMs);
  p.show(shown);
  p.take();
  EXPECT_EQ(p.image.encoding, Encoding::gray8);
  EXPECT_EQ(p.image.width, 64);
  EXPECT_EQ(p.image.height, 32);
  EXPECT_EQ(p.image.stride, 74);
  EXPECT_EQ(p.image.bytes, std::vector<std::uint8_t>(74 * 31 + 64, 77));
}

TEST(Frames, LiveTheNewestIsTakenAndTheOthersGoBackToTheDriver) {
  Played p(asking(false));
  p.open();
  for (std::uint32_t n = 0; n < 10; ++n) {  // more than there are buffers: none of them stays away
    p.driver.advance(33 * kMs);
    p.show(n);
    ASSERT_TRUE(eventually([&] { return p.camera->report().dequeued == n + 1; }));
  }
  p.take();
  EXPECT_EQ(p.frame.sequence, 9u);
  EXPECT_EQ(p.frame.lost_before, 0u);
  EXPECT_EQ(p.camera->report().stale, 9u);
  EXPECT_EQ(p.driver.queued_buffers(), 4);
  EXPECT_FALSE(p.camera->ready());
}

TEST(Frames, HolesOfStaleFramesAreNotForgotten) {
  Played p(asking(false));
  p.open();
  for (const std::uint32_t n : {0u, 3u, 4u}) {
    p.driver.advance(33 * kMs);
    p.show(n);
    ASSERT_TRUE(eventually([&] { return p.camera->report().dequeued > 0 && p.driver.queued_buffers() >= 3; }));
  }
  ASSERT_TRUE(eventually([&] { return p.camera->report().dequeued == 3; }));
  p.take();
  EXPECT_EQ(p.frame.sequence, 4u);
  EXPECT_EQ(p.frame.lost_before, 2u);
}

TEST(Frames, RecordedOnesKeepTheirOrderAndTheDriverItsBuffers) {
  Played p(asking(true, 6));
  p.open();
  for (std::uint32_t n = 0; n < 4; ++n) {
    p.driver.advance(33 * kMs);
    p.show(n);
  }
  ASSERT_TRUE(eventually([&] { return p.camera->report().dequeued == 4; }));
  EXPECT_EQ(p.driver.queued_buffers(), 2) << "left to the driver";
  for (std::uint32_t n = 0; n < 4; ++n) {
    p.take();
    EXPECT_EQ(p.frame.sequence, n);
  }
  EXPECT_EQ(p.camera->report().stale, 0u);
}

TEST(Frames, DamagedAndShortOnesFailAlone) {
  Played p;
  p.open();
  p.show_and_take(0);
  Shown broken;
  broken.sequence = 1;
  broken.stamp_ns = p.driver.now_ns();
  p.driver.advance(33 * kMs);
  broken.flags |= V4L2_BUF_FLAG_ERROR;
  p.show(broken);
  ASSERT_TRUE(p.camera->wait());
  EXPECT_THROW(p.camera->take(p.image, p.frame), FrameFault);
  EXPECT_EQ(p.frame.sequence, 1u);
  broken = {};
  broken.sequence = 2;
  broken.stamp_ns = p.driver.now_ns();
  broken.bytes_used = 100;
  p.driver.advance(33 * kMs);
  p.show(broken);
  ASSERT_TRUE(p.camera->wait());
  try {
    p.camera->take(p.image, p.frame);
    FAIL();
  } catch (const FrameFault& e) {
    EXPECT_THAT(e.what(), HasSubstr("has 100 bytes; expected 2048"));
  }
  p.show_and_take(3);
  EXPECT_EQ(p.frame.lost_before, 0u);
  EXPECT_EQ(p.camera->report().damaged, 1u);
  EXPECT_EQ(p.camera->report().too_short, 1u);
  EXPECT_EQ(p.driver.queued_buffers(), 4);
}

TEST(Frames, CompressedOnesAreAsLongAsTheyAre) {
  Played p;
  p.driver.offers = {{V4L2_PIX_FMT_MJPEG, {{64, 32}}, 30}};
  p.open();
  Shown shown;
  shown.bytes_used = 123;
  shown.stamp_ns = p.driver.now_ns();
  p.driver.advance(kMs);
  p.show(shown);
  p.take();
  EXPECT_EQ(p.image.encoding, Encoding::file);
  EXPECT_EQ(p.image.bytes.size(), 123u);
}

TEST(Stamps, ThatCannotBeRightAreReplacedAndCounted) {
  Played p;
  p.open();
  std::int64_t last = 0;
  const auto show = [&](std::uint32_t n, std::int64_t stamp_ns, std::uint32_t flags = Shown().flags) {
    p.driver.advance(33 * kMs);
    Shown shown{.sequence = n, .stamp_ns = stamp_ns, .flags = flags};
    p.show(shown);
    p.take();
    EXPECT_GT(p.frame.t_sensor_ns, last) << "never backwards";
    EXPECT_LE(p.frame.t_sensor_ns, p.driver.now_ns()) << "never in the future";
    last = p.frame.t_sensor_ns;
  };
  const std::int64_t start = p.driver.now_ns();
  show(0, start + 20 * kMs);
  EXPECT_EQ(p.frame.t_sensor_ns, start + 20 * kMs);
  EXPECT_EQ(p.camera->report().replaced_stamps.all(), 0u);
  show(1, start + 20 * kMs);  // stands still
  show(2, start + 10 * kMs);  // runs backwards
  show(3, p.driver.now_ns() + 3'600'000 * kMs);
  show(4, 5'000 * kMs);              // of a clock that began with the camera
  show(5, 1'700'000'000'000 * kMs);  // the time of day
  show(6, p.driver.now_ns(), V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN);
  show(7, p.driver.now_ns() + 20 * kMs);
  const StampCounts counts = p.camera->report().replaced_stamps;
  EXPECT_EQ(counts.backwards, 2u);
  EXPECT_EQ(counts.future, 2u);
  EXPECT_EQ(counts.before_start, 1u);
  EXPECT_EQ(counts.other_clock, 1u);
}

TEST(Stamps, SayWhetherTheyAreOfTheStartOrTheEnd) {
  Played p;
  p.open();
  p.show_and_take(0);
  EXPECT_TRUE(p.frame.at_start);
  p.driver.advance(33 * kMs);
  p.show(1, V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_EOF);
  p.take();
  EXPECT_FALSE(p.frame.at_start);
}

TEST(Counts, HaveHolesWrapAndStandStill) {
  Played p;
  p.open();
  const auto lost = [&](std::uint32_t sequence) {
    p.show_and_take(sequence);
    return p.frame.lost_before;
  };
  EXPECT_EQ(lost(4'294'967'290u), 0u) << "the first may be any";
  EXPECT_EQ(lost(4'294'967'295u), 4u);
  EXPECT_EQ(lost(1u), 1u) << "0 is missing";
  EXPECT_EQ(lost(1u), 0u) << "a driver that does not count";
  EXPECT_EQ(lost(0u), 0u) << "one that starts over";
  EXPECT_EQ(lost(2u), 1u);
  EXPECT_EQ(p.camera->report().lost, 6u);
}

TEST(Frames, LateOnesWithinThePatienceAreNoFault) {
  Played p;
  p.open();
  p.show_and_take(0);
  for (std::uint32_t n = 1; n <= 3; ++n) {
    p.driver.advance(1900 * kMs);
    p.show_and_take(n);
  }
  EXPECT_EQ(p.camera->report().outages.all(), 0u);
}

}  // namespace
}  // namespace pavo::v4l2::test
