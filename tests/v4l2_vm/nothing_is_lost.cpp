// 300 frames at the virtual camera's own rate: what is lost is lost by nobody but the emulated camera itself.
#include <cstdio>
#include <cstdlib>

#include "tests/v4l2_vm/support.h"
#include "tests/v4l2_vm/watched_calls.h"

namespace pavo::v4l2::test {
namespace {

constexpr int kFrames = 300;
constexpr FrameSize kSize{640, 480};

/// Takes so many frames; pauses for a moment before the tenth of them.
WatchedCalls::Losses losses_of(int count, std::chrono::milliseconds pause) {
  WatchedCalls watched;
  LiveCamera camera(watched, kVivid, asking_for(kSize, 25, "YUYV", kHonestStamps));
  EncodedImage image;
  CameraFrame frame;
  std::vector<std::uint32_t> taken;
  std::uint64_t told = 0;
  for (int n = 0; n < count; ++n) {
    if (n == 10) std::this_thread::sleep_for(pause);
    if (!camera.wait() || !camera.take(image, frame)) {
      ADD_FAILURE() << "frame " << n;
      break;
    }
    taken.push_back(frame.sequence);
    told += frame.lost_before;
  }
  camera.stop();
  const std::vector<WatchedCalls::Dequeued> dequeued = watched.dequeued();
  const WatchedCalls::Losses losses = watched.losses();
  EXPECT_GE(dequeued.size(), taken.size());
  for (std::size_t n = 0; n < std::min(taken.size(), dequeued.size()); ++n)
    EXPECT_EQ(taken[n], dequeued[n].sequence) << "what the driver gave was not handed on";
  EXPECT_EQ(camera.report().lost, static_cast<std::uint64_t>(losses.all)) << "every hole is told once";
  EXPECT_LE(told, camera.report().lost) << "a hole may lie behind the last frame that was taken";
  EXPECT_EQ(camera.report().damaged + camera.report().too_short + camera.report().outages.all(), 0u);
  return losses;
}

/// How another program fares at the same time of day, with as many buffers.
int lost_by_v4l2_ctl(int count) {
  const std::string told = "/tmp/v4l2-ctl.log";
  Child other({"/usr/bin/v4l2-ctl", "-d", kVivid, "--set-fmt-video=width=640,height=480,pixelformat=YUYV",
               "--set-parm=25", "--stream-mmap=8", "--stream-count=" + std::to_string(count), "--verbose"},
              told);
  EXPECT_EQ(other.wait(), 0);
  const std::string text = text_of(told);
  std::vector<std::uint64_t> sequence;
  for (std::size_t at = text.find("seq:"); at != std::string::npos; at = text.find("seq:", at + 1))
    sequence.push_back(std::strtoull(text.c_str() + at + 4, nullptr, 10));
  return sequence.empty() ? -1 : static_cast<int>(sequence.back() - sequence.front() + 1 - sequence.size());
}

TEST(Lost, AreNoneOf300Frames) {
  using std::chrono::milliseconds;
  WatchedCalls::Losses losses{.starved = 1};
  for (int attempt = 1; attempt <= 3 && losses.starved > 0; ++attempt) {
    losses = losses_of(kFrames, milliseconds(0));
    std::printf("lost of %d frames: %d, %d of them while the driver had no empty buffer\n", kFrames, losses.all,
                losses.starved);
    if (losses.all > 0) std::printf("lost by v4l2-ctl of as many: %d\n", lost_by_v4l2_ctl(kFrames));
  }
  EXPECT_EQ(losses.starved, 0) << "this process was kept from running for 8 frames, three times over";
}

TEST(Lost, AreFoundWhereTheReaderStarvesTheDriver) {
  const WatchedCalls::Losses losses = losses_of(20, std::chrono::milliseconds(1200));
  EXPECT_GT(losses.starved, 5);
}

}  // namespace
}  // namespace pavo::v4l2::test
