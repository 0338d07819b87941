// Every format of our list that vivid has, at every size: negotiated, streamed, complete, in sequence.
#include "tests/v4l2_vm/support.h"

namespace pavo::v4l2::test {
namespace {

/// Returns how many frames were lost. vivid itself is late, and leaves some out, where the machine that emulates it is
/// busy.
std::uint64_t expect_frames(const std::string& node, const std::string& format, const FrameSize& size, double rate_hz,
                            int count) {
  Kernel kernel;
  LiveCamera camera(kernel, node, asking_for(size, rate_hz, format, kHonestStamps));
  const std::string what = node + " " + camera.format().text();
  EncodedImage image;
  CameraFrame frame;
  std::int64_t last_ns = 0;
  std::uint64_t first = 0, lost = 0;
  for (std::uint64_t n = 0; n < static_cast<std::uint64_t>(count); ++n) {
    if (!camera.wait() || !camera.take(image, frame)) {
      ADD_FAILURE() << what;
      return lost;
    }
    if (n == 0) first = frame.sequence;
    lost += frame.lost_before;
    EXPECT_EQ(frame.sequence, first + n + lost) << what;
    EXPECT_GT(frame.t_sensor_ns, last_ns) << what;
    EXPECT_LE(frame.t_sensor_ns, frame.t_dequeue_ns) << what;
    EXPECT_TRUE(frame.at_start) << what;
    EXPECT_EQ(image.encoding, camera.format().pixels.encoding) << what;
    EXPECT_EQ(image.bytes.size(), camera.format().bytes_needed) << what;
    last_ns = frame.t_sensor_ns;
  }
  EXPECT_EQ(camera.format().size, size);
  EXPECT_EQ(camera.format().pixels.name, format);
  EXPECT_EQ(camera.report().replaced_stamps.all(), 0u) << what;
  EXPECT_EQ(camera.report().outages.all(), 0u) << what;
  EXPECT_GE(camera.report().lost, lost) << what;  // more may have come since
  return lost;
}

std::vector<OfferedFormat> offered_by(const std::string& node) {
  Kernel kernel;
  return Device(kernel, node).formats();
}

TEST(Vivid, StreamsEveryFormatAtEverySize) {
  int streamed = 0;
  for (const OfferedFormat& format : offered_by(kVivid)) {
    if (!pixel_format_of(format.fourcc)) continue;
    for (const SizeRange& size : format.sizes) {
      const bool large = size.largest.width > 1280;  // 2 and 5 frames a second
      expect_frames(kVivid, fourcc_text(format.fourcc), size.largest, 10, large ? 1 : 3);
      ++streamed;
    }
  }
  EXPECT_GE(streamed, 10 * 6);
}

TEST(Vivid, StreamsEveryFormatThroughTheMultiPlanarInterface) {
  std::vector<std::string> streamed;
  for (const OfferedFormat& format : offered_by(kMultiPlanar)) {
    if (!pixel_format_of(format.fourcc)) continue;
    expect_frames(kMultiPlanar, fourcc_text(format.fourcc), {640, 480}, 25, 3);
    streamed.push_back(fourcc_text(format.fourcc));
  }
  EXPECT_THAT(streamed, ::testing::IsSupersetOf({"GREY", "NV12", "NM12", "YUYV", "UYVY", "RGB3", "BGR3", "RGGB"}));
}

// vivid's stamps of the frame's end are what it computes beforehand: they lie ahead.
TEST(Vivid, StampsOfTheFutureAreReplaced) {
  Kernel kernel;
  LiveCamera camera(kernel, kVivid, asking_for({320, 180}, 10, "", "timestamp_source=0", false));
  EncodedImage image;
  CameraFrame frame;
  std::int64_t last_ns = 0;
  for (int n = 0; n < 5; ++n) {
    ASSERT_TRUE(camera.wait());
    ASSERT_TRUE(camera.take(image, frame));
    EXPECT_FALSE(frame.at_start);
    EXPECT_LE(frame.t_sensor_ns, frame.t_dequeue_ns);
    EXPECT_GT(frame.t_sensor_ns, last_ns);
    last_ns = frame.t_sensor_ns;
  }
  EXPECT_GT(camera.report().replaced_stamps.future, 0u);
}

// 2^32 frames in a second: the count starts again at 0, and nothing is lost.
TEST(Vivid, ASequenceThatWrapsHasNoGap) {
  Kernel kernel;
  LiveCamera camera(kernel, kVivid, asking_for({320, 180}, 10, "", "wrap_sequence_number=true"));
  EncodedImage image;
  CameraFrame frame;
  bool wrapped = false;
  for (std::uint32_t last = 0; !wrapped; last = frame.sequence) {
    ASSERT_TRUE(camera.wait());
    ASSERT_TRUE(camera.take(image, frame));
    EXPECT_LT(frame.lost_before, 100u) << frame.sequence;
    wrapped = frame.sequence < last;
    if (camera.report().dequeued > 300) GTEST_SKIP() << "this vivid does not wrap";
  }
  press("wrap_sequence_number", "false");
}

TEST(Vivid, OffersWhatItDoesNotHaveAsOneLine) {
  Kernel kernel;
  try {
    const LiveCamera camera(kernel, kVivid, asking_for({123, 45}, 10));
    FAIL();
  } catch (const DeviceError& e) {
    EXPECT_THAT(e.what(), ::testing::AllOf(::testing::HasSubstr("has no 123x45"), ::testing::HasSubstr("640x480")));
  }
}

TEST(Vivid, ThatIsInUseIsToldSo) {
  Kernel kernel;
  const LiveCamera first(kernel, kVivid, asking_for({320, 180}, 10));
  try {
    const LiveCamera second(kernel, kVivid, asking_for({640, 480}, 10));
    FAIL();
  } catch (const DeviceError& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr("in use by another program"));
  }
}

}  // namespace
}  // namespace pavo::v4l2::test
