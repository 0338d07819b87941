#include "tests/sequences/small_sequences.h"

namespace pavo {
namespace {

using namespace test;
using testing::HasSubstr;

void write_tum(const TemporaryFolder& folder) {
  folder.write("rgb.txt",
               "# color images\n# file: 'rgbd_dataset_freiburg1_xyz.bag'\n# timestamp filename\n"
               "1305031102.175304 rgb/1305031102.175304.pgm\n1305031102.211214 rgb/1305031102.211214.pgm\n"
               "1305031102.243211 rgb/1305031102.243211.pgm\n");
  for (const char* name : {"1305031102.175304", "1305031102.211214", "1305031102.243211"}) {
    folder.write("rgb/" + std::string(name) + ".pgm", pgm(64, 48, 'x'));
  }
  folder.write("camera.txt", kKittiCalibration);
}

TEST(TumRgbd, NeedsACalibration) {
  TemporaryFolder folder;
  write_tum(folder);
  EXPECT_THAT(open_error(folder.string()), HasSubstr("give the camera's with --calibration FILE"));
}

TEST(TumRgbd, FramesAndInterpolatedTruth) {
  TemporaryFolder folder;
  write_tum(folder);
  folder.write("groundtruth.txt",
               "# ground truth trajectory\n1305031102.1700 0 0 0 0 0 0 1\n1305031102.1753 1 0 0 0 0 0 1\n"
               "1305031102.2000 2 0 0 0 0 0 1\n1305031102.2200 4 0 0 0 0 0 1\n");
  SequenceOptions options;
  options.calibration = (folder / "camera.txt").string();
  const auto sequence = open_sequence(folder.string(), options);
  const SequenceInfo& info = sequence->info();
  EXPECT_EQ(info.layout, "TUM RGB-D");
  const auto frames = read_all(*sequence);
  ASSERT_EQ(frames.size(), 3);
  EXPECT_EQ(frames[0].stamp.t_capture_ns, 1305031102'175304000);
  EXPECT_EQ(frames[0].stamp.name, "1305031102.175304.pgm");
  ASSERT_TRUE(info.groundtruth);
  EXPECT_EQ(info.groundtruth_frames, (std::vector<std::int64_t>{0, 1}))
      << "the third frame comes after the truth's end";
  const double first = 1 + 0.000004 / 0.0247, second = 2 + 2 * 0.011214 / 0.02;
  EXPECT_NEAR(info.groundtruth->T_w_c[1].t.x(), second - first, 1e-9);
}

TEST(TumRgbd, TruthOfAnotherTimeIsRefused) {
  TemporaryFolder folder;
  write_tum(folder);
  folder.write("groundtruth.txt", "5 0 0 0 0 0 0 1\n6 0 0 0 0 0 0 1\n");
  SequenceOptions options;
  options.calibration = (folder / "camera.txt").string();
  EXPECT_THAT(open_error(folder.string(), options),
              HasSubstr("goes from 5.000000 s to 6.000000 s, and has no frame of 1305031102"));
}

TEST(TumRgbd, RefusesAMalformedIndex) {
  TemporaryFolder folder;
  write_tum(folder);
  folder.write("rgb.txt", "# x\n2.0 rgb/a.png\n1.0 rgb/b.png\n");
  EXPECT_THAT(open_error(folder.string()), HasSubstr("rgb.txt:3: the time does not come after"));
  folder.write("rgb.txt", "1.0 rgb/a.png rgb/b.png\n");
  EXPECT_THAT(open_error(folder.string()), HasSubstr("rgb.txt:1: expected 'seconds file'"));
  folder.write("rgb.txt", "");
  EXPECT_THAT(open_error(folder.string()), HasSubstr("rgb.txt: lists no frame"));
}

}  // namespace
}  // namespace pavo
