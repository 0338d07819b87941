#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "tests/sequences/small_sequences.h"

namespace pavo {
namespace {

using namespace test;
using testing::HasSubstr;

constexpr int kVideoWidth = 96, kVideoHeight = 64;

/// Frame i is gray of brightness 10 i. Empty where this OpenCV cannot write videos.
std::string write_video(const TemporaryFolder& folder, int frames, const std::string& name = "drive.avi",
                        int codec = cv::VideoWriter::fourcc('M', 'J', 'P', 'G')) {
  const std::string path = (folder / name).string();
  cv::VideoWriter writer(path, cv::CAP_FFMPEG, codec, 25, {kVideoWidth, kVideoHeight});
  if (!writer.isOpened()) return {};
  for (int i = 0; i < frames; ++i) writer.write(cv::Mat(kVideoHeight, kVideoWidth, CV_8UC3, cv::Scalar::all(10 * i)));
  return path;
}

TEST(Video, FramesGoStraightIntoTheImage) {
  TemporaryFolder folder;
  const std::string path = write_video(folder, 12);
  if (path.empty()) GTEST_SKIP() << "OpenCV's videoio cannot write a video here (no FFmpeg)";
  const auto sequence = open_sequence(path);
  EXPECT_EQ(sequence->info().layout, "video");
  EXPECT_TRUE(sequence->info().has_times);
  EncodedImage image;
  FrameStamp stamp;
  const std::uint8_t* memory = nullptr;
  for (int i = 0; i < 12; ++i) {
    ASSERT_EQ(sequence->peek()->index, i);
    ASSERT_TRUE(sequence->read(image, stamp)) << i;
    EXPECT_EQ(stamp.index, i);
    EXPECT_NEAR(static_cast<double>(stamp.t_capture_ns), i * 40e6, 1e6);
    EXPECT_EQ(image.encoding, Encoding::bgr24);
    EXPECT_EQ(image.width, kVideoWidth);
    EXPECT_EQ(image.height, kVideoHeight);
    EXPECT_EQ(image.stride, 3 * kVideoWidth);
    ASSERT_EQ(image.bytes.size(), 3u * kVideoWidth * kVideoHeight);
    EXPECT_NEAR(image.bytes[1000], 10 * i, 3);
    if (memory) {
      EXPECT_EQ(image.bytes.data(), memory);
    }
    memory = image.bytes.data();
  }
  EXPECT_FALSE(sequence->peek());
  EXPECT_FALSE(sequence->read(image, stamp));
}

// As two recordings written one behind the other are: the second begins at 0 again.
TEST(Video, TimesThatRunBackwardsAreReplacedAndCounted) {
  TemporaryFolder folder;
  const std::string once = write_video(folder, 10, "once.ts", cv::VideoWriter::fourcc('m', 'p', 'g', '2'));
  if (once.empty()) GTEST_SKIP() << "OpenCV's videoio cannot write a video here (no FFmpeg)";
  const auto sequence = open_sequence(folder.write("twice.ts", bytes_of(once) + bytes_of(once)));
  EXPECT_EQ(sequence->info().rate_hz, 25);
  EncodedImage image;
  FrameStamp stamp;
  std::vector<std::int64_t> times_ns;
  while (sequence->read(image, stamp)) times_ns.push_back(stamp.t_capture_ns);
  ASSERT_EQ(times_ns.size(), 20u);
  for (std::size_t i = 1; i < times_ns.size(); ++i) EXPECT_EQ(times_ns[i] - times_ns[i - 1], 40'000'000) << i;
  EXPECT_EQ(sequence->times_replaced(), 10);
}

TEST(Video, FramesCanBeSkipped) {
  TemporaryFolder folder;
  const std::string path = write_video(folder, 5);
  if (path.empty()) GTEST_SKIP() << "OpenCV's videoio cannot write a video here (no FFmpeg)";
  const auto sequence = open_sequence(path);
  EncodedImage image;
  FrameStamp stamp;
  ASSERT_TRUE(sequence->skip());
  ASSERT_TRUE(sequence->skip());
  ASSERT_TRUE(sequence->read(image, stamp));
  EXPECT_EQ(stamp.index, 2);
  EXPECT_NEAR(image.bytes[1000], 20, 3);
}

TEST(Video, CalibrationBesideAndTruthByFrame) {
  TemporaryFolder folder;
  const std::string path = write_video(folder, 3);
  if (path.empty()) GTEST_SKIP() << "OpenCV's videoio cannot write a video here (no FFmpeg)";
  EXPECT_THAT(open_sequence(path)->info().calibration_source, HasSubstr("drive.yaml"));
  folder.write("drive.yaml",
               "image_width: 96\nimage_height: 64\nK: [90, 0, 48, 0, 90, 32, 0, 0, 1]\nD: [0, 0, 0, 0]\n");
  folder.write("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1\n1 0 0 0 0 1 0 0 0 0 1 2\n");
  SequenceOptions options;
  options.groundtruth = (folder / "poses.txt").string();
  const auto sequence = open_sequence(path, options);
  EXPECT_EQ(sequence->info().camera->fx, 90);
  EXPECT_EQ(sequence->info().groundtruth->T_w_c[2].t.z(), 2);
  EXPECT_EQ(sequence->info().groundtruth_frames, (std::vector<std::int64_t>{0, 1, 2}));
  folder.write("poses.txt", "1 0 0 0 0 0 0 1\n");
  EXPECT_THAT(open_error(path, options), HasSubstr("goes by time"));
}

TEST(Video, ACutFileEndsWithACountedFrame) {
  TemporaryFolder folder;
  const std::string path = write_video(folder, 200);
  if (path.empty()) GTEST_SKIP() << "OpenCV's videoio cannot write a video here (no FFmpeg)";
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  const auto frames = read_all(*open_sequence(path));
  ASSERT_GT(frames.size(), 2u);
  if (frames.size() >= 199) GTEST_SKIP() << "this container tells no count once it is cut";
  EXPECT_THAT(frames.back().error, HasSubstr("the file is cut or corrupt"));
  EXPECT_EQ(frames[frames.size() - 2].error, "");
}

}  // namespace
}  // namespace pavo
