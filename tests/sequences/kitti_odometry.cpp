#include <fstream>

#include "tests/sequences/small_sequences.h"

namespace pavo {
namespace {

using namespace test;
using testing::HasSubstr;

TEST(KittiOdometry, FramesTimesCalibrationAndTruth) {
  TemporaryFolder folder;
  write_kitti(folder, 12);
  const auto sequence = open_sequence(folder.string());
  const SequenceInfo& info = sequence->info();
  EXPECT_EQ(info.layout, "KITTI odometry");
  EXPECT_EQ(info.frame_count, 12);
  EXPECT_TRUE(info.has_times);
  ASSERT_TRUE(info.camera);
  EXPECT_EQ(info.camera->fx, 50);
  EXPECT_EQ(info.camera->width, 64) << "calib.txt has no size: it is the first image's";
  EXPECT_EQ(info.camera->height, 48);
  EXPECT_THAT(info.calibration_source, HasSubstr("calib.txt, P0"));
  ASSERT_TRUE(info.groundtruth);
  ASSERT_EQ(info.groundtruth->T_w_c.size(), 12);
  EXPECT_EQ(info.groundtruth->T_w_c[7].t, Eigen::Vector3d(0, 0, 7));
  EXPECT_EQ(info.groundtruth_frames.back(), 11);

  const auto frames = read_all(*sequence);
  ASSERT_EQ(frames.size(), 12);
  for (int i = 0; i < 12; ++i) {
    const ReadFrame& frame = frames[static_cast<std::size_t>(i)];
    EXPECT_EQ(frame.stamp.index, i);
    EXPECT_EQ(frame.stamp.t_capture_ns, i * 100'000'000LL);
    EXPECT_EQ(frame.stamp.name, frame_name(i));
    EXPECT_EQ(frame.bytes, pgm(64, 48, static_cast<char>(i)));
    EXPECT_EQ(info.groundtruth->t_ns[static_cast<std::size_t>(i)], frame.stamp.t_capture_ns);
  }
}

TEST(KittiOdometry, TheFolderOfACameraNamesThatCamera) {
  TemporaryFolder folder;
  write_kitti(folder, 2);
  folder.write("image_2/000000.pgm", pgm(64, 48, 'x'));
  folder.write("image_2/000001.pgm", pgm(64, 48, 'y'));
  EXPECT_EQ(open_sequence(folder.string())->info().camera->fx, 50) << "the first camera, P0";
  EXPECT_EQ(open_sequence((folder / "image_2").string())->info().camera->fx, 60) << "P2";
  EXPECT_EQ(open_sequence((folder / "image_2/").string())->info().camera->fx, 60) << "P2";
  std::filesystem::remove_all(folder / "image_0");
  EXPECT_EQ(open_sequence(folder.string())->info().camera->fx, 60) << "image_2 is all there is";
}

TEST(KittiOdometry, PosesWhereTheBenchmarkPutsThem) {
  TemporaryFolder folder;
  folder.write("sequences/05/image_0/000000.pgm", pgm(64, 48, 'x'));
  folder.write("sequences/05/image_0/000001.pgm", pgm(64, 48, 'x'));
  folder.write("sequences/05/calib.txt", kKittiCalibration);
  folder.write("poses/05.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 3\n");
  const auto sequence = open_sequence((folder / "sequences/05/").string());
  ASSERT_TRUE(sequence->info().groundtruth);
  EXPECT_EQ(sequence->info().groundtruth->T_w_c[1].t.z(), 3);
  EXPECT_THAT(sequence->info().groundtruth_source, HasSubstr("poses/05.txt"));
}

TEST(KittiOdometry, TruthStartsWithTheIdentity) {
  TemporaryFolder folder;
  write_kitti(folder, 2);
  // The first pose looks along x from (5, 0, 0); the second is 2 m farther along its view.
  folder.write("poses.txt", "0 0 1 5 0 1 0 0 -1 0 0 0\n0 0 1 7 0 1 0 0 -1 0 0 0\n");
  const auto sequence = open_sequence(folder.string());
  const auto& poses = sequence->info().groundtruth->T_w_c;
  EXPECT_EQ(poses[0].R, Eigen::Matrix3d::Identity());
  EXPECT_EQ(poses[0].t, Eigen::Vector3d::Zero());
  EXPECT_LT((poses[1].t - Eigen::Vector3d(0, 0, 2)).norm(), 1e-12);
  EXPECT_LT((poses[1].R - Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

TEST(KittiOdometry, PosesOfTheFirstFramesOnly) {
  TemporaryFolder folder;
  write_kitti(folder, 5);
  folder.write("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1\n");
  const auto sequence = open_sequence(folder.string());
  EXPECT_EQ(sequence->info().groundtruth_frames, (std::vector<std::int64_t>{0, 1}));
  EXPECT_THAT(sequence->info().groundtruth_source, HasSubstr("covers 2 of the 5 frames"));
}

TEST(KittiOdometry, ACutKeepsTheLinesOfItsFrames) {
  TemporaryFolder folder;
  write_kitti(folder, 10);
  for (const int i : {0, 1, 2, 5, 9}) std::filesystem::remove(folder / ("image_0/" + frame_name(i)));
  const auto sequence = open_sequence(folder.string());
  const auto frames = read_all(*sequence);
  ASSERT_EQ(frames.size(), 5);
  EXPECT_EQ(frames[0].stamp.t_capture_ns, 300'000'000);
  EXPECT_EQ(frames[2].stamp.t_capture_ns, 600'000'000) << "behind the hole";
  EXPECT_EQ(sequence->info().groundtruth->T_w_c[2].t.z(), 3) << "frame 6 seen from frame 3";
}

TEST(KittiOdometry, MoreTimesThanImagesThatHaveNoNumbersIsUnclear) {
  TemporaryFolder folder;
  write_kitti(folder, 3);
  std::filesystem::rename(folder / "image_0/000001.pgm", folder / "image_0/b.pgm");
  std::filesystem::remove(folder / "image_0/000002.pgm");
  EXPECT_THAT(open_error(folder.string()),
              HasSubstr("times.txt: has 3 lines for 2 images, and which of them is b.pgm's is not clear"));
}

TEST(KittiOdometry, GivenFilesTakePrecedence) {
  TemporaryFolder folder;
  write_kitti(folder, 3);
  folder.write("other/calib.txt", "P0: 55 0 32 0 0 55 24 0 0 0 1 0\n");
  folder.write("other/poses.tum", "0 0 0 0 0 0 0 1\n0.2 4 0 0 0 0 0 1\n");
  SequenceOptions options;
  options.calibration = (folder / "other/calib.txt").string();
  options.groundtruth = (folder / "other/poses.tum").string();
  const auto sequence = open_sequence(folder.string(), options);
  EXPECT_EQ(sequence->info().camera->fx, 55);
  EXPECT_EQ(sequence->info().groundtruth->T_w_c[1].t, Eigen::Vector3d(2, 0, 0)) << "interpolated";

  options.groundtruth = "none";
  const auto without = open_sequence(folder.string(), options);
  EXPECT_FALSE(without->info().groundtruth);
  EXPECT_THAT(without->info().groundtruth_source, HasSubstr("--groundtruth none"));
}

TEST(KittiOdometry, ARateReplacesMissingTimesAndNoOthers) {
  TemporaryFolder folder;
  write_kitti(folder, 3);
  SequenceOptions options;
  options.rate_hz = 20;
  EXPECT_EQ(read_all(*open_sequence(folder.string(), options))[2].stamp.t_capture_ns, 200'000'000);
  std::filesystem::remove(folder / "times.txt");
  EXPECT_EQ(read_all(*open_sequence(folder.string(), options))[2].stamp.t_capture_ns, 100'000'000);
  const auto without = open_sequence(folder.string());
  EXPECT_FALSE(without->info().has_times);
  EXPECT_EQ(read_all(*without)[2].stamp.t_capture_ns, 2) << "the frame's number";
  EXPECT_TRUE(without->info().groundtruth->t_ns.empty());
}

TEST(KittiOdometry, WithoutACalibrationSaysWhatWasLookedFor) {
  TemporaryFolder folder;
  write_kitti(folder, 1);
  std::filesystem::remove(folder / "calib.txt");
  const auto sequence = open_sequence(folder.string());
  EXPECT_FALSE(sequence->info().camera);
  EXPECT_THAT(sequence->info().calibration_source, HasSubstr("calib.txt"));
  EXPECT_THAT(sequence->info().calibration_source, HasSubstr("--calibration FILE"));
}

}  // namespace
}  // namespace pavo
