// What is agreed upon with a driver, and how it is told where nothing can be.
#include "drivers/v4l2/controls.h"
#include "tests/v4l2/support.h"

namespace pavo::v4l2::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(Negotiation, TakesTheCheapestFormatThatIsFastEnough) {
  Played p;
  p.driver.offers = {{V4L2_PIX_FMT_MJPEG, {{64, 32}}, 30},
                     {V4L2_PIX_FMT_YUYV, {{64, 32}}, 30},
                     {V4L2_PIX_FMT_GREY, {{32, 16}}, 30}};  // not at this size
  p.open();
  EXPECT_EQ(p.camera->format().pixels.name, "YUYV");
  EXPECT_EQ(p.camera->format().rate_hz, 30);
}

TEST(Negotiation, TakesTheFasterFormatWhereTheCheaperOneIsSlow) {
  Played p;
  p.driver.offers = {{V4L2_PIX_FMT_YUYV, {{64, 32}}, 10}, {V4L2_PIX_FMT_MJPEG, {{64, 32}}, 30}};
  p.open();
  EXPECT_EQ(p.camera->format().pixels.name, "MJPG");
}

TEST(Negotiation, TakesTheFormatThatIsNamed) {
  Played p;
  p.driver.offers = {{V4L2_PIX_FMT_GREY, {{64, 32}}, 30}, {V4L2_PIX_FMT_YUYV, {{64, 32}}, 30}};
  p.options.format.format = "YUYV";
  p.open();
  EXPECT_EQ(p.camera->format().pixels.name, "YUYV");
}

TEST(Negotiation, TriesTheNextFormatWhereTheBusHasNoRoom) {
  Played p;
  p.driver.offers = {{V4L2_PIX_FMT_YUYV, {{64, 32}}, 30}, {V4L2_PIX_FMT_MJPEG, {{64, 32}}, 30}};
  p.driver.fail(VIDIOC_STREAMON, -ENOSPC);
  p.open();
  EXPECT_EQ(p.camera->format().pixels.name, "MJPG");
}

TEST(Negotiation, SaysWhatToDoWhereTheBusHasNoRoomForAnything) {
  Played p;
  p.driver.fail(VIDIOC_STREAMON, -ENOSPC, 10);
  EXPECT_THAT(refusal(p), AllOf(HasSubstr("USB bus has no bandwidth left"), HasSubstr("--rate")));
}

TEST(Negotiation, RefusesAnotherSizeThanTheCalibrations) {
  Played p;
  p.driver.changes = [](v4l2_pix_format& pix) { pix.width = 32; };
  EXPECT_THAT(refusal(p), HasSubstr("was asked for GREY 64x32 and gives GREY 32x32"));
}

TEST(Negotiation, TriesTheNextFormatWhereTheDriverMakesAnotherOfIt) {
  Played p;
  p.driver.offers = {{V4L2_PIX_FMT_GREY, {{64, 32}}, 30}, {V4L2_PIX_FMT_YUYV, {{64, 32}}, 30}};
  p.driver.changes = [](v4l2_pix_format& pix) { pix.pixelformat = V4L2_PIX_FMT_YUYV; };
  p.open();
  EXPECT_EQ(p.camera->format().pixels.name, "YUYV");
}

TEST(Negotiation, RefusesHalfPictures) {
  Played p;
  p.driver.changes = [](v4l2_pix_format& pix) { pix.field = V4L2_FIELD_INTERLACED; };
  EXPECT_THAT(refusal(p), HasSubstr("two half pictures"));
}

TEST(Negotiation, NamesWhatThereIsWhereNothingFits) {
  Played p;
  p.options.format.size = {640, 480};
  EXPECT_THAT(refusal(p), AllOf(HasSubstr("has no 640x480"), HasSubstr("GREY 64x32 32x16")));
  p.options.format = {.size = {64, 32}, .rate_hz = 30, .format = "NV12"};
  EXPECT_THAT(refusal(p), HasSubstr("has no NV12 64x32"));
}

TEST(Negotiation, ReadsTheRateBack) {
  Played p;
  p.options.format.rate_hz = 90;
  p.open();
  EXPECT_EQ(p.camera->format().rate_hz, 30);
}

TEST(Negotiation, LivesWithFewerBuffersAndNotWithOne) {
  Played p;
  p.driver.most_buffers = 2;
  p.open();
  EXPECT_EQ(p.camera->report().buffers, 2);
  for (std::uint32_t n = 0; n < 5; ++n) p.show_and_take(n);
  p.camera.reset();
  p.driver.most_buffers = 1;
  EXPECT_THAT(refusal(p), HasSubstr("gives 1 of 4 buffers; expected 2 or more"));
}

TEST(Negotiation, SignalsInBetweenAreNoErrors) {
  Played p;
  for (const unsigned long request : {VIDIOC_QUERYCAP, VIDIOC_S_FMT, VIDIOC_REQBUFS, VIDIOC_STREAMON})
    p.driver.fail(request, -EINTR, 3);
  p.open();
  p.driver.fail(VIDIOC_DQBUF, -EINTR, 3);
  p.driver.fail(VIDIOC_QBUF, -EINTR, 3);
  p.show_and_take(0);
  EXPECT_EQ(p.camera->report().outages.all(), 0u);
}

TEST(Negotiation, AStartThatFailsOnceIsTriedAgain) {
  for (const unsigned long request : {VIDIOC_REQBUFS, VIDIOC_QBUF, VIDIOC_STREAMON}) {
    Played p;
    p.driver.fail(request, -EIO);
    p.open();
    p.show_and_take(0);
  }
  Played p;
  p.driver.fail(VIDIOC_STREAMON, -EIO, 3);
  EXPECT_THAT(refusal(p), HasSubstr("cannot start streaming: Input/output error"));
}

TEST(Nodes, ThatAreNoCamerasAreToldInOneLine) {
  const auto told = [](auto&& change) {
    Played p;
    change(p.driver);
    const std::string message = refusal(p);
    EXPECT_EQ(message.find('\n'), std::string::npos);
    EXPECT_TRUE(message.starts_with("/dev/video0: ")) << message;
    return message;
  };
  EXPECT_THAT(told([](PlayedDriver& d) { d.present = false; }), HasSubstr("there is no such device"));
  EXPECT_THAT(told([](PlayedDriver& d) { d.open_fails = -EACCES; }), HasSubstr("no permission"));
  EXPECT_THAT(told([](PlayedDriver& d) { d.open_fails = -EBUSY; }), HasSubstr("in use by another program"));
  EXPECT_THAT(told([](PlayedDriver& d) { d.fail(VIDIOC_QUERYCAP, -ENOTTY); }), HasSubstr("no V4L2 device"));
  EXPECT_THAT(told([](PlayedDriver& d) { d.device_caps = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING; }),
              HasSubstr("for metadata"));
  EXPECT_THAT(told([](PlayedDriver& d) { d.device_caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_READWRITE; }),
              HasSubstr("cannot stream"));
  EXPECT_THAT(told([](PlayedDriver& d) { d.fail(VIDIOC_S_FMT, -EBUSY); }), HasSubstr("in use by another program"));
}

TEST(Controls, AreReadStrictly) {
  const auto controls = parse_controls(" auto_exposure = Manual Mode,gain=20 , ");
  ASSERT_EQ(controls.size(), 2u);
  EXPECT_EQ(controls[0].name, "auto_exposure");
  EXPECT_EQ(controls[0].value, "Manual Mode");
  EXPECT_EQ(controls[1].value, "20");
  EXPECT_TRUE(parse_controls("").empty());
  for (const char* wrong : {"gain", "gain=", "=3", "gain=1,,x=2"})
    EXPECT_THROW(parse_controls(wrong), std::runtime_error) << wrong;
}

TEST(Controls, ThatACameraDoesNotHaveAreAnError) {
  Played p;
  p.options.controls = parse_controls("gain=1");
  EXPECT_THAT(refusal(p), HasSubstr("control gain: 'Played' has none of this name"));
}

}  // namespace
}  // namespace pavo::v4l2::test
