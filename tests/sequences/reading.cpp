// Reading frames: what is at fault stays with its frame, and nothing blocks, leaks or grows.
#include <sys/stat.h>
#include <unistd.h>

#include "tests/sequences/small_sequences.h"

namespace pavo {
namespace {

using namespace test;
using testing::HasSubstr;

TEST(Reading, PeekTellsWhatReadWillDeliver) {
  TemporaryFolder folder;
  write_kitti(folder, 4);
  const auto sequence = open_sequence(folder.string());
  EncodedImage image;
  FrameStamp stamp;
  EXPECT_EQ(sequence->peek()->index, 0);
  EXPECT_EQ(sequence->peek()->index, 0) << "peeking does not move on";
  ASSERT_TRUE(sequence->read(image, stamp));
  EXPECT_EQ(stamp.index, 0);
  ASSERT_TRUE(sequence->skip());
  EXPECT_EQ(sequence->peek()->index, 2);
  EXPECT_EQ(sequence->peek()->t_capture_ns, 200'000'000);
  EXPECT_EQ(sequence->peek()->name, "000002.pgm");
  ASSERT_TRUE(sequence->read(image, stamp));
  EXPECT_EQ(stamp.index, 2);
  ASSERT_TRUE(sequence->skip());
  EXPECT_FALSE(sequence->peek());
  EXPECT_FALSE(sequence->skip());
  EXPECT_FALSE(sequence->read(image, stamp));
}

TEST(Reading, TheRateIsTheMedianOfTheTimes) {
  TemporaryFolder folder;
  write_kitti(folder, 4);
  folder.write("times.txt", "0\n0.05\n60\n60.05\n");  // a minute at the traffic lights
  EXPECT_DOUBLE_EQ(open_sequence(folder.string())->info().rate_hz, 20);
  std::filesystem::remove(folder / "times.txt");
  EXPECT_EQ(open_sequence(folder.string())->info().rate_hz, 0);
  EXPECT_NEAR(open_sequence(folder.string(), {.calibration = {}, .groundtruth = {}, .rate_hz = 30})->info().rate_hz, 30,
              1e-6);
}

TEST(Reading, AFaultStaysWithItsFrame) {
  TemporaryFolder folder;
  write_kitti(folder, 7);
  std::filesystem::remove(folder / "image_0/000001.pgm");
  ASSERT_EQ(::mkfifo((folder / "image_0/000001.pgm").c_str(), 0600), 0);
  std::filesystem::remove(folder / "image_0/000002.pgm");
  std::filesystem::create_directory(folder / "image_0/000002.pgm");
  folder.write("image_0/000003.pgm", "");
  std::filesystem::remove(folder / "image_0/000004.pgm");
  std::filesystem::create_symlink("/nowhere/at/all", folder / "image_0/000004.pgm");
  const auto sequence = open_sequence(folder.string());
  std::filesystem::remove(folder / "image_0/000005.pgm");  // vanishes while the run goes on

  const auto frames = read_all(*sequence);
  ASSERT_EQ(frames.size(), 7);
  EXPECT_EQ(frames[0].error, "");
  EXPECT_THAT(frames[1].error, HasSubstr("000001.pgm: is no regular file"));
  EXPECT_THAT(frames[2].error, HasSubstr("000002.pgm: is no regular file"));
  EXPECT_THAT(frames[3].error, HasSubstr("000003.pgm: is empty"));
  EXPECT_THAT(frames[4].error, HasSubstr("000004.pgm: cannot be read"));
  EXPECT_THAT(frames[5].error, HasSubstr("000005.pgm: cannot be read: No such file"));
  EXPECT_EQ(frames[6].bytes, pgm(64, 48, 6));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].stamp.index, static_cast<std::int64_t>(i)) << "the stamp is filled also where reading fails";
    EXPECT_EQ(frames[i].error.find('\n'), std::string::npos);
  }
}

TEST(Reading, TheFirstImageThatCanBeReadTellsTheSize) {
  TemporaryFolder folder;
  write_kitti(folder, 3);
  folder.write("image_0/000000.pgm", "garbage");
  folder.write("image_0/000001.pgm", "");
  EXPECT_EQ(open_sequence(folder.string())->info().camera->width, 64);
  folder.write("image_0/000002.pgm", "P5 0 0");
  EXPECT_THAT(open_error(folder.string()),
              HasSubstr("000000.pgm: is no image that can be read (nor is any other frame of "));
}

TEST(Reading, MemoryIsUsedAgain) {
  TemporaryFolder folder;
  write_kitti(folder, 6);
  const auto sequence = open_sequence(folder.string());
  EncodedImage image;
  FrameStamp stamp;
  ASSERT_TRUE(sequence->read(image, stamp));
  const std::uint8_t* memory = image.bytes.data();
  while (sequence->read(image, stamp)) EXPECT_EQ(image.bytes.data(), memory);
}

TEST(Reading, DescriptorsAreClosed) {
  TemporaryFolder folder;
  write_kitti(folder, 20);
  const auto open_files = [] {
    std::filesystem::directory_iterator all("/proc/self/fd");
    return std::distance(begin(all), end(all));
  };
  const auto before = open_files();
  for (int i = 0; i < 3; ++i) read_all(*open_sequence(folder.string()));
  EXPECT_EQ(open_files(), before);
}

}  // namespace
}  // namespace pavo
