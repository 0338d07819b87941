// A camera that hangs, fails or is pulled out comes back, and nothing is left open or mapped meanwhile (which the
// played driver watches).
#include "tests/v4l2/support.h"

namespace pavo::v4l2::test {
namespace {

TEST(Outages, AHangingCameraIsOpenedAgain) {
  Played p;
  p.open();
  p.show_and_take(0);
  ASSERT_TRUE(eventually([&] {
    p.driver.advance(100 * kMs);
    return p.camera->report().outages.hung == 1;  // not what is told: that comes before the old session is closed
  }));
  EXPECT_TRUE(p.told("no frame came for 2.00 s"));
  p.come_back();
  EXPECT_TRUE(p.frame.after_outage);
  EXPECT_EQ(p.camera->report().outages.hung, 1u);
  EXPECT_EQ(p.driver.opened(), 2);
}

TEST(Outages, ASlowCameraHasTenPeriods) {
  Played p;
  p.options.format.rate_hz = 1;
  p.driver.offers = {{V4L2_PIX_FMT_GREY, {{64, 32}}, 1}};
  p.open();
  for (std::uint32_t n = 0; n < 3; ++n) {
    p.driver.advance(8000 * kMs);
    p.show_and_take(n);
  }
  EXPECT_EQ(p.camera->report().outages.all(), 0u);
}

TEST(Outages, AnErrorWhileStreamingIsRecoveredFrom) {
  Played p;
  p.open();
  for (std::uint32_t n = 0; n < 3; ++n) {
    p.show_and_take(2 * n);
    p.driver.fail(VIDIOC_DQBUF, -EIO);
    ASSERT_TRUE(eventually([&] { return p.camera->report().outages.failed == n + 1; }));
    p.come_back(1000);  // a driver that never resets its count
    EXPECT_TRUE(p.frame.after_outage);
    EXPECT_GE(p.frame.lost_before, 1u);
    EXPECT_LT(p.frame.lost_before, 900u) << "the count of a new stream says nothing about the old one";
  }
  EXPECT_TRUE(p.told("Input/output error"));
  EXPECT_TRUE(p.told("streams again"));
}

TEST(Outages, AnUnpluggedCameraIsWaitedForAndBackAtOnce) {
  Played p;
  p.open();
  p.show_and_take(0);
  for (std::uint64_t n = 1; n <= 20; ++n) {
    p.driver.unplug();
    ASSERT_TRUE(eventually([&] { return p.camera->report().outages.unplugged == n; }));
    for (int look = 0; look < 20; ++look) {  // without a word from /dev it looks every 500 ms
      const int before = p.driver.found_none();
      ASSERT_TRUE(eventually([&] {
        p.driver.advance(100 * kMs);
        return p.driver.found_none() > before;
      }));
    }
    EXPECT_FALSE(p.camera->report().streaming);
    p.driver.plug_in();
    ASSERT_TRUE(eventually([&] { return p.driver.streams(); })) << "without the clock's help: the node is watched";
    p.show_and_take(0);
    EXPECT_TRUE(p.frame.after_outage);
    EXPECT_GE(p.frame.lost_before, 250u) << "about 10 s of 30 Hz";
  }
  EXPECT_LT(p.camera->report().outages.longest_return_ns, 1000 * kMs);
  EXPECT_GE(p.camera->report().outages.away_ns, 180'000 * kMs);
}

TEST(Outages, OpeningIsTriedUntilItWorks) {
  Played p;
  p.open();
  p.show_and_take(0);
  p.driver.fail(VIDIOC_STREAMON, -EIO, 3);
  p.driver.fail(VIDIOC_REQBUFS, -EINVAL, 2);
  p.driver.fail(VIDIOC_DQBUF, -EIO);
  ASSERT_TRUE(eventually([&] { return p.camera->report().outages.failed == 1; }));
  p.come_back();
  EXPECT_TRUE(p.told("cannot start streaming"));
}

TEST(Outages, AnotherCameraAtTheSamePlaceIsNotTaken) {
  Played p;
  p.open();
  p.show_and_take(0);
  p.driver.unplug();
  ASSERT_TRUE(eventually([&] { return p.camera->report().outages.unplugged == 1; }));
  p.driver.with_lock([&] { p.driver.card = "Stranger"; });
  p.driver.plug_in();
  ASSERT_TRUE(eventually([&] {
    p.driver.advance(100 * kMs);
    return p.told("is another camera now ('Stranger')");
  }));
  p.driver.with_lock([&] { p.driver.card = "Played"; });
  p.come_back();
}

TEST(Outages, TheFormatIsAgreedUponAnew) {
  Played p;
  p.driver.offers = {{V4L2_PIX_FMT_GREY, {{64, 32}}, 30}};
  p.open();
  p.show_and_take(0);
  p.driver.unplug();
  ASSERT_TRUE(eventually([&] { return p.camera->report().outages.unplugged == 1; }));
  p.driver.with_lock([&] { p.driver.offers = {{V4L2_PIX_FMT_YUYV, {{64, 32}}, 30}}; });
  p.driver.plug_in();
  p.come_back();
  EXPECT_EQ(p.image.encoding, Encoding::yuyv);
  EXPECT_EQ(p.image.bytes.size(), 64u * 32 * 2);
}

TEST(Outages, ABufferThatIsRefusedOnceIsGivenBackLater) {
  Played p;
  p.open();
  p.show_and_take(0);
  p.driver.fail(VIDIOC_QBUF, -EINVAL);
  p.show_and_take(1);
  for (std::uint32_t n = 2; n < 6; ++n) p.show_and_take(n);
  EXPECT_TRUE(eventually([&] { return p.driver.queued_buffers() == 4; }));
  EXPECT_EQ(p.camera->report().outages.all(), 0u);
}

TEST(Outages, GivingUpIsAnError) {
  Played p;
  p.options.give_up_ns = 3000 * kMs;
  p.open();
  p.show_and_take(0);
  p.driver.unplug();
  ASSERT_TRUE(eventually([&] {
    p.driver.advance(100 * kMs);
    return p.camera->ended();
  }));
  EXPECT_FALSE(p.camera->wait());
  EXPECT_THROW(p.camera->rethrow_error(), DeviceError);
}

TEST(Outages, AnInterruptEndsTheWaitingOfBothSides) {
  for (const bool unplugged : {false, true}) {
    Played p;
    p.open();
    p.show_and_take(0);
    if (unplugged) p.driver.unplug();
    std::jthread interrupting([&] { p.camera->interrupt(); });
    EXPECT_FALSE(p.camera->wait());
    EXPECT_EQ(p.camera->stop(), 0u);
    EXPECT_NO_THROW(p.camera->rethrow_error());
  }
}

}  // namespace
}  // namespace pavo::v4l2::test
