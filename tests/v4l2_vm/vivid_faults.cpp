// Each fault that vivid can inject while frames are read: the frame fails, or the camera is opened again, and nothing
// is left open or mapped.
#include "tests/v4l2_vm/support.h"

namespace pavo::v4l2::test {
namespace {

struct Faults : ::testing::Test {
  Faults() : descriptors_before(open_descriptors()) {
    camera.emplace(kernel, kVivid, asking_for({320, 180}, 10), [this](const std::string& event) {
      const std::lock_guard lock(mutex);
      events += event + "\n";
    });
  }
  ~Faults() override {
    camera.reset();
    EXPECT_EQ(mapped_buffers(), 0);
    EXPECT_EQ(open_descriptors(), descriptors_before);
  }
  /// Reads until `there` says so, or 100 frames have come.
  template <class There>
  void read_until(There&& there) {
    for (int n = 0; n < 100 && !there(); ++n) {
      ASSERT_TRUE(camera->wait());
      try {
        if (camera->take(image, frame)) {
          ++good;
          gaps += frame.lost_before;
        }
      } catch (const FrameFault&) {
        ++broken;
        gaps += frame.lost_before;
      }
    }
    EXPECT_TRUE(there());
  }
  void read(int more) {
    const int until = good + more;
    read_until([&] { return good >= until; });
  }
  CameraReport::Outages outages() const { return camera->report().outages; }

  Kernel kernel;
  int descriptors_before;
  std::mutex mutex;
  std::string events;
  EncodedImage image;
  CameraFrame frame;
  int good = 0, broken = 0;
  std::uint64_t gaps = 0;
  std::optional<LiveCamera> camera;
};

TEST_F(Faults, ADamagedFrameFailsAlone) {
  read(2);
  press("inject_v4l2_buf_flag_error");
  read_until([&] { return broken == 1; });
  read(3);
  EXPECT_EQ(camera->report().damaged, 1u);
  EXPECT_EQ(outages().all(), 0u);
}

TEST_F(Faults, ABufferThatIsRefusedOnceIsGivenBackAgain) {
  read(2);
  const int mapped = mapped_buffers();
  press("inject_vidioc_qbuf_error");
  read(12);  // more than there are buffers: none was lost
  EXPECT_EQ(outages().all(), 0u);
  EXPECT_EQ(mapped_buffers(), mapped);
}

TEST_F(Faults, AFatalErrorIsRecoveredFrom) {
  read(2);
  const int descriptors = open_descriptors(), mapped = mapped_buffers();
  press("inject_fatal_streaming_error");
  read_until([&] { return frame.after_outage; });
  EXPECT_GE(frame.lost_before, 1u);
  EXPECT_EQ(outages().failed, 1u);
  read(3);
  EXPECT_EQ(open_descriptors(), descriptors);
  EXPECT_EQ(mapped_buffers(), mapped);
  const std::lock_guard lock(mutex);
  EXPECT_THAT(events, ::testing::HasSubstr("Input/output error"));
  EXPECT_THAT(events, ::testing::HasSubstr("streams again"));
}

TEST_F(Faults, AnOpeningThatFailsAtFirstIsTriedAgain) {
  for (const char* stumble :
       {"inject_vidioc_reqbufs_error", "inject_vidioc_streamon_error", "inject_vidioc_qbuf_error"}) {
    read(2);
    frame.after_outage = false;
    press(stumble);
    press("inject_fatal_streaming_error");
    read_until([&] { return frame.after_outage; });
  }
  EXPECT_GE(outages().failed, 3u);
  read(2);
}

TEST_F(Faults, LostBuffersAreGaps) {
  read(2);
  press("percentage_of_dropped_buffers", "30");
  read(30);
  press("percentage_of_dropped_buffers", "0");
  EXPECT_GT(gaps, 3u);
  EXPECT_EQ(outages().all(), 0u);
  read(10);
  EXPECT_EQ(camera->report().lost, gaps + 0u) << "every hole is told once";
}

TEST_F(Faults, ADisconnectedCameraIsOpenedAgain) {
  read(2);
  press("disconnect");
  read_until([&] { return frame.after_outage; });
  EXPECT_EQ(outages().unplugged, 1u);
  read(3);
}

TEST_F(Faults, ADriverThatIsTakenAwayIsWaitedFor) {
  read(2);
  const int mapped = mapped_buffers();
  for (int n = 0; n < 2; ++n) {
    frame.after_outage = false;
    write_file("/sys/bus/platform/drivers/vivid/unbind", "vivid.0");
    ASSERT_TRUE(eventually([&] { return !std::filesystem::exists(kVivid) && !camera->report().streaming; }));
    EXPECT_EQ(mapped_buffers(), 0);
    write_file("/sys/bus/platform/drivers/vivid/bind", "vivid.0");
    read_until([&] { return frame.after_outage; });
  }
  EXPECT_EQ(outages().unplugged, 2u);
  read(3);
  EXPECT_EQ(mapped_buffers(), mapped);
}

TEST(Start, ThatStumblesIsTriedAgain) {
  for (const char* stumble :
       {"inject_vidioc_reqbufs_error", "inject_vidioc_streamon_error", "inject_vidioc_qbuf_error"}) {
    press(stumble);
    Kernel kernel;
    LiveCamera camera(kernel, kVivid, asking_for({320, 180}, 10));
    EXPECT_TRUE(camera.wait()) << stumble;
  }
}

}  // namespace
}  // namespace pavo::v4l2::test
