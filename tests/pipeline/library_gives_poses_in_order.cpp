// VisualOdometry: what a program that links the library sees.
#include <gmock/gmock.h>

#include <atomic>
#include <cmath>
#include <condition_variable>
#include <mutex>

#include "pavo/visual_odometry.h"
#include "tests/pipeline/street.h"
#include "tests/support/temporary.h"

namespace pavo::test {
namespace {

using ::testing::HasSubstr;

class Library : public ::testing::Test {
 protected:
  Library() : config(folder.write("c.toml", "[people]\nenabled = false\n[engine]\nworkers = 2\n")) {}

  static bool push(VisualOdometry& odometry, std::size_t n) {
    const EncodedImage& image = street().frames[forth_and_back(n)];
    return odometry.push(image.bytes.data(), image.stride, 100'000'000 * static_cast<std::int64_t>(n));
  }
  TemporaryFolder folder;
  std::string config;
};

TEST_F(Library, OneForEveryFrame) {
  std::vector<PoseEstimate> poses;
  VisualOdometry odometry(street().camera, {.config_file = config},
                          [&](const PoseEstimate& pose) { poses.push_back(pose); });
  for (std::size_t n = 0; n < 30; ++n) EXPECT_TRUE(push(odometry, n));
  odometry.finish();
  odometry.finish();  // does nothing
  ASSERT_EQ(poses.size(), 30u);
  for (std::size_t n = 0; n < poses.size(); ++n) {
    EXPECT_EQ(poses[n].frame, static_cast<std::int64_t>(n));
    EXPECT_EQ(poses[n].t_capture_ns, 100'000'000 * static_cast<std::int64_t>(n));
    EXPECT_EQ(poses[n].failure, "");
  }
  EXPECT_EQ(poses[0].T_world_camera, PoseEstimate().T_world_camera);
  EXPECT_EQ(poses[7].quality, "tracked");
  EXPECT_GT(poses[7].inliers, 20);
  EXPECT_GT(poses[29].T_world_camera[11], 20) << "29 steps of length 1, mostly forward";
  EXPECT_THROW(push(odometry, 30), std::logic_error);
}

TEST_F(Library, RowsMayBeFartherApart) {
  const EncodedImage& image = street().frames[0];
  const int width = street().camera.width, height = street().camera.height, stride = width + 77;
  std::vector<std::uint8_t> wide(static_cast<std::size_t>(stride * height), 255);
  std::vector<PoseEstimate> poses;
  VisualOdometry odometry(street().camera, {.config_file = config}, [&](const PoseEstimate& p) { poses.push_back(p); });
  push(odometry, 0);
  for (int y = 0; y < height; ++y) std::copy_n(image.bytes.data() + y * image.stride, width, wide.data() + y * stride);
  odometry.push(wide.data(), stride, 1);
  odometry.finish();
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[1].quality, "standing") << "the same picture";
}

TEST_F(Library, TimesThatRunBackwardsAreSurvived) {
  std::vector<PoseEstimate> poses;
  VisualOdometry odometry(street().camera, {.config_file = config}, [&](const PoseEstimate& p) { poses.push_back(p); });
  const std::vector<std::int64_t> times{0, 100, 50, 50, INT64_MAX / 2, INT64_MIN / 2, 0};
  for (std::size_t n = 0; n < times.size(); ++n)
    odometry.push(street().frames[n].bytes.data(), street().frames[n].stride, times[n]);
  odometry.finish();
  ASSERT_EQ(poses.size(), times.size());
  for (const PoseEstimate& pose : poses)
    for (const double v : pose.T_world_camera) EXPECT_TRUE(std::isfinite(v));
}

TEST_F(Library, WhatOnPoseThrowsEndsIt) {
  int calls = 0;
  VisualOdometry odometry(street().camera, {.config_file = config}, [&](const PoseEstimate& pose) {
    ++calls;
    if (pose.frame == 3) throw std::runtime_error("enough");
  });
  bool room = true;
  for (std::size_t n = 0; n < 1000 && room; ++n) room = push(odometry, n);
  EXPECT_FALSE(room);
  EXPECT_EQ(complaint([&] { odometry.finish(); }), "enough");
  EXPECT_EQ(calls, 4);
}

TEST_F(Library, LiveNeverWaits) {
  folder.write("c.toml", "[people]\nenabled = false\n[engine]\nworkers = 2\nslots = 4\nlive_credits = 32\n");
  std::mutex mutex;
  std::condition_variable changed;
  bool go_on = false;
  std::vector<std::int64_t> frames;
  VisualOdometry odometry(street().camera, {.config_file = config, .live = true}, [&](const PoseEstimate& pose) {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return go_on; });
    frames.push_back(pose.frame);
  });
  std::vector<std::int64_t> taken;
  for (std::size_t n = 0; n < 100; ++n)  // nothing comes out: a push that waits would wait for ever
    if (push(odometry, n)) taken.push_back(static_cast<std::int64_t>(n));
  {
    const std::lock_guard lock(mutex);
    go_on = true;
  }
  changed.notify_all();
  odometry.finish();
  EXPECT_GE(taken.size(), 1u);
  EXPECT_LE(taken.size(), 4u);
  EXPECT_EQ(frames, taken);
}

TEST_F(Library, MayBeLeftWithoutFinish) {
  std::atomic<int> calls{0};
  {
    VisualOdometry odometry(street().camera, {.config_file = config}, [&](const PoseEstimate&) { ++calls; });
    for (std::size_t n = 0; n < 10; ++n) push(odometry, n);
  }
  EXPECT_LE(calls, 10);
  const VisualOdometry unused(street().camera, {.config_file = config}, [](const PoseEstimate&) {});
}

TEST_F(Library, SaysInOneLineWhatIsWrong) {
  const auto told = [&](const Camera& camera, const std::string& file, VisualOdometry::OnPose on_pose) {
    return complaint([&] { VisualOdometry(camera, {.config_file = file}, std::move(on_pose)); });
  };
  const auto ignore = [](const PoseEstimate&) {};
  Camera flat = street().camera;
  flat.fy = 0;
  EXPECT_THAT(told(flat, config, ignore), HasSubstr("camera"));
  flat = street().camera;
  flat.height = 0;
  EXPECT_NE(told(flat, config, ignore), "");
  EXPECT_THAT(told(street().camera, folder.file("none.toml"), ignore), HasSubstr("none.toml: cannot be read"));
  EXPECT_THAT(told(street().camera, folder.write("k.toml", "[engine]\nworker = 1\n"), ignore),
              HasSubstr("did you mean engine.workers?"));
  EXPECT_THAT(told(street().camera, folder.write("s.toml", "[odometry]\nscale = 'groundtruth'\n"), ignore),
              HasSubstr("odometry.scale must be unit"));
  EXPECT_THAT(told(street().camera, config, nullptr), HasSubstr("no on_pose"));
  VisualOdometry odometry(street().camera, {.config_file = config}, ignore);
  EXPECT_THAT(complaint([&] { odometry.push(nullptr, 320, 0); }), HasSubstr("no pixels"));
  EXPECT_THAT(complaint([&] { odometry.push(street().frames[0].bytes.data(), 319, 0); }), HasSubstr("at least"));
}

}  // namespace
}  // namespace pavo::test
