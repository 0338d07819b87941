// Where the ground is seen, the scan of a later frame looks for feet by it: by which frame's look does not depend on
// time.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <thread>

#include "drivers/synthetic/synthetic_street.h"
#include "engine/clock.h"
#include "pavo/horizon_stage.h"
#include "pavo/odometry_pipeline.h"

namespace pavo::test {
namespace {

class RenderedStreet : public Source<Frame> {
 public:
  RenderedStreet() : street_(options()) {}
  bool read(FrameInfo& info, Frame& frame) override {
    FrameStamp stamp;
    if (!street_.read(frame.encoded, stamp)) return false;
    info.source_index = next_++;
    info.t_capture_ns = stamp.t_capture_ns;
    return true;
  }
  std::optional<std::int64_t> next_arrival_ns() override { return 0; }
  Camera camera() { return *street_.info().camera; }

 private:
  static SyntheticOptions options() {
    SyntheticOptions o;
    o.frames = 16;
    o.width = 400;
    o.height = 160;
    return o;
  }
  SyntheticStreet street_;
  std::int64_t next_ = 0;
};

struct Seen {
  std::optional<StandingPrior> standing;
  std::optional<GroundAttitude> attitude;
  SE3 T_w_c;
};

std::vector<Seen> run(Config config, int workers, bool delays) {
  config.engine.workers = workers;
  RenderedStreet source;
  SteadyClock clock;
  OdometryPipeline odometry(config, source.camera(), std::make_shared<UnitStep>(), Input::encoded, clock);
  std::vector<Seen> seen;
  odometry.engine().deliver([&](const Frame& frame, const FrameInfo&, const Outcome& outcome) {
    EXPECT_FALSE(outcome.failed) << outcome.message;
    seen.push_back({frame.standing, frame.pose.attitude, frame.pose.T_w_c});
  });
  if (delays)
    odometry.engine().disturb_with([](std::size_t node, std::uint64_t sequence) {
      std::minstd_rand random(static_cast<std::uint32_t>(1 + 131 * node + 7919 * sequence));
      random.discard(3);
      if (random() % 3 == 0) std::this_thread::sleep_for(std::chrono::microseconds(random() % 3000));
    });
  odometry.engine().run(source);
  return seen;
}

Config with_height(const std::string& estimator) {
  Config config;
  config.odometry.estimator = estimator;
  config.odometry.scale = "camera-height";
  config.camera.height_m = 1.65;
  config.camera.pitch_rad = -0.01;
  return config;
}

class PitchFlowsBack : public ::testing::TestWithParam<const char*> {};

TEST_P(PitchFlowsBack, TheSameWhateverTheTimes) {
  const Config config = with_height(GetParam());
  const std::vector<Seen> one = run(config, 1, false);
  ASSERT_EQ(one.size(), 16u);
  for (const int workers : {1, 3}) {
    const std::vector<Seen> other = run(config, workers, true);
    ASSERT_EQ(other.size(), one.size());
    for (std::size_t k = 0; k < one.size(); ++k) {
      EXPECT_EQ(other[k].standing, one[k].standing) << k;
      EXPECT_EQ(other[k].T_w_c.t, one[k].T_w_c.t) << k;
    }
  }
  // The first ones by what was configured, a later one by what was seen.
  const std::optional<StandingPrior> configured = standing_prior(config, RenderedStreet().camera());
  for (std::size_t k = 0; k < kHorizonDelay; ++k) EXPECT_EQ(one[k].standing, configured);
  EXPECT_NE(one.back().standing, configured);
  EXPECT_NEAR(one.back().standing->horizon_px, configured->horizon_px, 20);
}

INSTANTIATE_TEST_SUITE_P(Estimators, PitchFlowsBack, ::testing::Values("frame-to-frame", "keyframe"),
                         [](const auto& tested) {
                           return std::string(tested.param) == "keyframe" ? std::string("keyframe") : "frame_to_frame";
                         });

TEST(PitchFlowsBackFrameToFrame, AsItWasSoManyFramesBefore) {
  Config config = with_height("frame-to-frame");
  const std::vector<Seen> seen = run(config, 2, true);
  const Camera camera = RenderedStreet().camera();
  std::size_t looked = 0;
  for (std::size_t k = kHorizonDelay; k < seen.size(); ++k) {
    const auto& attitude = seen[k - kHorizonDelay].attitude;
    if (!attitude) continue;
    ++looked;
    config.camera.pitch_rad = attitude->pitch_rad;
    EXPECT_EQ(seen[k].standing, standing_prior(config, camera)) << k;
  }
  EXPECT_GT(looked, 4u);
}

TEST(PitchFlowsBackHeld, UntilThereIsANewerOne) {
  Config config = with_height("keyframe");
  const Camera camera{400, 160, 300, 300, 200, 80, Lens::rectified, {}};
  HorizonStage horizon(config, camera);
  std::optional<StandingPrior> standing;
  const MapUpdate* nothing = nullptr;
  horizon(nothing, standing);
  EXPECT_EQ(standing, standing_prior(config, camera));
  MapUpdate update;
  update.ground = down_of({.pitch_rad = 0.05}) / 1.65;
  horizon(&update, standing);
  EXPECT_NEAR(standing->horizon_px, 80 + 300 * std::tan(0.05), 1e-9);
  const std::optional<StandingPrior> held = standing;
  update.ground.reset();  // a map without a look at the ground
  horizon(&update, standing);
  horizon.missed(nothing, standing);
  EXPECT_EQ(standing, held);
}

}  // namespace
}  // namespace pavo::test
