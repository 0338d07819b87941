// Every frame, in order, the same poses to the bit, however long anything takes and however many workers there are.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <opencv2/core/utility.hpp>
#include <random>
#include <thread>

#include "engine/clock.h"
#include "pavo/odometry_pipeline.h"
#include "tests/pipeline/street.h"

namespace pavo::test {
namespace {

std::vector<SE3> poses_of(Config config, std::size_t frames, bool delays, std::uint32_t seed = 0) {
  SteadyClock clock;
  const Street& where = config.people.enabled ? high_street() : street();
  OdometryPipeline odometry(config, where.camera, std::make_shared<UnitStep>(), Input::encoded, clock);
  std::vector<SE3> poses;
  std::minstd_rand source_random(seed + 1), delivery_random(seed + 2);
  const auto delay = [&](std::minstd_rand& random) {
    if (delays && random() % 3 == 0) std::this_thread::sleep_for(std::chrono::microseconds(random() % 3000));
  };
  odometry.engine().deliver([&](const Frame& frame, const FrameInfo& info, const Outcome& outcome) {
    EXPECT_EQ(info.source_index, static_cast<std::int64_t>(poses.size()));
    EXPECT_FALSE(outcome.failed) << outcome.message;
    delay(delivery_random);
    poses.push_back(frame.pose.T_w_c);
  });
  // Every stage's call, too: by its node and frame, which no two threads do at the same time.
  if (delays)
    odometry.engine().disturb_with([seed](std::size_t node, std::uint64_t sequence) {
      std::minstd_rand random(static_cast<std::uint32_t>(1 + seed + 131 * node + 7919 * sequence));
      random.discard(3);
      if (random() % 3 == 0) std::this_thread::sleep_for(std::chrono::microseconds(random() % 2000));
    });
  StreetSource source(
      frames,
      [&](std::size_t n) {
        delay(source_random);
        if (n % 11 == 10) std::this_thread::yield();
      },
      where);
  odometry.engine().run(source);
  return poses;
}

void expect_same(const std::vector<SE3>& a, const std::vector<SE3>& b, const std::string& what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].R, b[i].R) << what << ", frame " << i;
    EXPECT_EQ(a[i].t, b[i].t) << what << ", frame " << i;
  }
}

class Timing : public ::testing::TestWithParam<const char*> {
 protected:
  Config config() const {
    Config c;
    const std::string tested = GetParam();
    c.people.enabled = tested == "keyframe_and_people";
    c.people.threshold = 0.02;  // so that there are some
    c.odometry.compare = true;
    c.odometry.estimator = tested.starts_with("keyframe") ? "keyframe" : "frame-to-frame";
    if (tested == "klt") c.odometry.tracker = "klt";
    return c;
  }
};

#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
constexpr std::size_t kFramesARun = 60;
const std::vector<int> kWorkers{1, 4};
constexpr std::uint32_t kRuns = 1;
#else
constexpr std::size_t kFramesARun = 12;
const std::vector<int> kWorkers{1, 2, 3, 4, 8};
constexpr std::uint32_t kRuns = 5;
#endif

TEST_P(Timing, ChangesNoPose) {
  Config c = config();
  c.engine.workers = 1;
  const std::vector<SE3> expected = poses_of(c, kFramesARun, false);
  ASSERT_EQ(expected.size(), kFramesARun);
  EXPECT_EQ(expected[0].R, Eigen::Matrix3d::Identity());
  EXPECT_EQ(expected[0].t, Eigen::Vector3d::Zero());
  for (const int workers : kWorkers)
    for (std::uint32_t run = 0; run < kRuns; ++run) {
      c.engine.workers = workers;
      c.engine.slots = run == 1 ? 5 : 0;
      expect_same(poses_of(c, kFramesARun, true, 100 * run + static_cast<std::uint32_t>(workers)), expected,
                  std::to_string(workers) + " workers, run " + std::to_string(run));
    }
}

INSTANTIATE_TEST_SUITE_P(Trackers, Timing, ::testing::Values("descriptor", "klt", "keyframe", "keyframe_and_people"),
                         [](const auto& tested) { return std::string(tested.param); });

TEST(PipelineOfStages, TurnsOpenCvsOwnThreadsOff) {
  cv::setNumThreads(4);
  SteadyClock clock;
  const OdometryPipeline odometry({}, street().camera, std::make_shared<UnitStep>(), Input::encoded, clock);
  EXPECT_EQ(cv::getNumThreads(), 1);
  std::atomic<int> elsewhere{0};
  const auto here = std::this_thread::get_id();
  cv::parallel_for_(cv::Range(0, 1000), [&](const cv::Range&) { elsewhere += std::this_thread::get_id() != here; });
  EXPECT_EQ(elsewhere, 0);
}

TEST(PipelineOfStages, RefusesWhatDoesNotGoTogether) {
  SteadyClock clock;
  const auto make = [&](const Config& config, const Camera& camera) {
    OdometryPipeline odometry(config, camera, std::make_shared<UnitStep>(), Input::encoded, clock);
    odometry.engine().prepare();
  };
  Config few;
  few.engine.slots = 1;
  EXPECT_THROW(make(few, street().camera), std::invalid_argument) << "odometry needs the frame before";
  for (const auto& spoil : std::vector<std::function<void(Camera&)>>{
           [](Camera& c) { c.width = 0; }, [](Camera& c) { c.height = -1; }, [](Camera& c) { c.fx = 0; },
           [](Camera& c) { c.fy = std::nan(""); }, [](Camera& c) { c.cx = HUGE_VAL; },
           [](Camera& c) {
             c.lens = Lens::radial_tangential;
             c.distortion[0] = std::nan("");
           }}) {
    Camera camera = street().camera;
    spoil(camera);
    EXPECT_ANY_THROW(make({}, camera));
  }
}

}  // namespace
}  // namespace pavo::test
