// The recorded sequences that development uses, where they are at hand.
#include "tests/sequences/small_sequences.h"
#include "tests/support/data.h"

namespace pavo {
namespace {

using namespace test;

struct Real {
  const char* name;
  const char* layout;
  int frames, width, height;
  double path_m;
};

void PrintTo(const Real& real, std::ostream* out) {
  *out << real.name;
}

class RealSequence : public testing::TestWithParam<Real> {};

TEST_P(RealSequence, OpensWithAllThatItHas) {
  const Real real = GetParam();
  PAVO_NEEDS_DATA(std::filesystem::path("sequences") / real.name);
  const auto sequence = open_sequence((data_folder() / "sequences" / real.name).string());
  const SequenceInfo& info = sequence->info();
  EXPECT_EQ(info.layout, real.layout);
  EXPECT_EQ(info.frame_count, real.frames);
  EXPECT_TRUE(info.has_times);
  ASSERT_TRUE(info.camera);
  EXPECT_EQ(info.camera->width, real.width);
  EXPECT_EQ(info.camera->height, real.height);
  ASSERT_TRUE(info.groundtruth);
  ASSERT_EQ(info.groundtruth->T_w_c.size(), static_cast<std::size_t>(real.frames));
  double path_m = 0;
  for (std::size_t i = 1; i < info.groundtruth->T_w_c.size(); ++i) {
    path_m += (info.groundtruth->T_w_c[i].t - info.groundtruth->T_w_c[i - 1].t).norm();
  }
  EXPECT_NEAR(path_m, real.path_m, 0.5);  // GPS jitters: its path is a little longer than the road
  EncodedImage image;
  FrameStamp stamp;
  int frames = 0;
  for (std::int64_t last_ns = -1; sequence->read(image, stamp); last_ns = stamp.t_capture_ns, ++frames)
    EXPECT_GT(stamp.t_capture_ns, last_ns);
  EXPECT_EQ(frames, real.frames);
}

INSTANTIATE_TEST_SUITE_P(Development, RealSequence,
                         testing::Values(Real{"kitti05-300", "KITTI odometry", 300, 1226, 370, 231},
                                         Real{"kitti01-51", "KITTI odometry", 51, 1241, 376, 52},
                                         Real{"kitti-city-134", "KITTI odometry", 134, 1242, 375, 122.6},
                                         Real{"kitti-street-108", "KITTI odometry", 108, 1242, 375, 107},
                                         Real{"euroc-standstill-25", "EuRoC", 25, 752, 480, 0}),
                         [](const testing::TestParamInfo<Real>& real) {
                           std::string name = real.param.name;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace pavo
