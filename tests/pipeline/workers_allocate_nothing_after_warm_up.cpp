// The engine and the stages allocate nothing once every slot has seen the largest frame: counted on the pipeline's
// workers, from operator new; with people, and with keyframes. What libraries allocate for decoding and KLT has a
// number that does not grow. (Delivery is the caller's.)
#include <gtest/gtest.h>
#include <sys/prctl.h>

#include <atomic>
#include <cstring>

#include "engine/clock.h"
#include "pavo/odometry_pipeline.h"
#include "tests/pipeline/street.h"
#include "tests/support/counted_allocations.h"

namespace {

std::atomic<bool> counting{false};

bool on_a_worker() {
  thread_local const bool worker = [] {
    char name[16] = {};
    ::prctl(PR_GET_NAME, name);
    return std::strncmp(name, "pavo-worker", 11) == 0;
  }();
  return worker;
}

bool counts() {
  return counting.load(std::memory_order_relaxed) && on_a_worker();
}

}  // namespace

namespace pavo::test {
namespace {

// Sanitizers make frames slow, and see to malloc themselves: fewer frames, and only what comes from operator new.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif
constexpr std::size_t kFrames = kSanitized ? 60 : 500;

/// What kFrames allocate, on the workers, when every slot has seen all that it ever will.
long allocations_of_frames(Config config, const Street& where) {
  config.engine.workers = 1;  // then it is known what memory has seen which frame
  config.engine.slots = 6;
  SteadyClock clock;
  OdometryPipeline odometry(config, where.camera, std::make_shared<UnitStep>(), Input::encoded, clock);
  std::size_t delivered = 0, people = 0, keyframes = 0;
  odometry.engine().deliver([&](const Frame& frame, const FrameInfo&, const Outcome& outcome) {
    delivered += outcome.failed ? 0 : 1;
    people += frame.people.size();
    keyframes += frame.keyframe.is_keyframe ? 1 : 0;
  });
  // 58 frames, forth and back, shift the street by 4 of 6 slots: after three rounds of it all slots have seen all.
  const std::size_t warm_up = 3 * 2 * (where.frames.size() - 1) + 6;
  StreetSource source(
      warm_up + kFrames, [&](std::size_t n) { counting = n >= warm_up; }, where);
  counts_here = &counts;
  allocations = 0;
  odometry.engine().run(source);
  counting = false;
  EXPECT_EQ(delivered, warm_up + kFrames);
  EXPECT_EQ(people > 0, config.people.enabled);
  EXPECT_EQ(keyframes > 20, config.odometry.estimator == "keyframe");
  return allocations.load();
}

TEST(Workers, AllocateNothingAfterWarmUp) {
  Config config;
  config.people.enabled = false;
  config.odometry.estimator = "frame-to-frame";
  config.odometry.compare = true;
  EXPECT_EQ(allocations_of_frames(config, street()), 0);
}

TEST(Workers, AllocateNothingWithPeople) {
  Config config;
  config.odometry.estimator = "frame-to-frame";
  config.people.threshold = 0.02;  // so that there are some
  EXPECT_EQ(allocations_of_frames(config, high_street()), 0);
}

TEST(Workers, AllocateNothingWithKeyframes) {
  Config config;
  config.people.enabled = false;
  config.odometry.estimator = "keyframe";
  EXPECT_EQ(allocations_of_frames(config, street()), 0) << "the map's own thread aside";
}

// As `pavo run --scale camera-height=1.65` has it.
TEST(Workers, AllocateNothingWithKeyframesPeopleAndGround) {
  Config config;
  config.odometry.estimator = "keyframe";
  config.odometry.scale = "camera-height";
  config.camera.height_m = 1.65;
  config.people.threshold = 0.02;
  EXPECT_EQ(allocations_of_frames(config, high_street()), 0) << "the map's own thread aside";
}

// cv::calcOpticalFlowPyrLK, 4.6 on Debian 12: its pyramids, and what it hands to its loops.
constexpr long kOfKlt = 20;

TEST(Workers, AllocateWhatOpenCVsFlowNeedsAndNoMore) {
  Config config;
  config.people.enabled = false;
  config.odometry.estimator = "frame-to-frame";
  config.odometry.tracker = "klt";
  config.features.max_features = 100;
  const long allocated = allocations_of_frames(config, street());
  if (!kSanitized) {
    EXPECT_GE(allocated, kOfKlt * static_cast<long>(kFrames));
  }
  EXPECT_LE(allocated, (kOfKlt + 1) * static_cast<long>(kFrames)) << "it grows";
}

TEST(Workers, AreCountedWhereTheyAllocate) {
  Config config;
  config.people.enabled = false;
  SteadyClock clock;
  OdometryPipeline odometry(config, street().camera, std::make_shared<UnitStep>(), Input::encoded, clock);
  odometry.engine().deliver([&](const Frame&, const FrameInfo&, const Outcome&) { std::vector<int> v(100); });
  counts_here = &counts;
  allocations = 0;
  counting = true;
  StreetSource source(4);
  odometry.engine().run(source);
  counting = false;
  EXPECT_GE(allocations.load(), 1);
}

}  // namespace
}  // namespace pavo::test
