// A video of two recordings, one behind the other: the second's times begin at 0 again.
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "tests/command/command.h"

namespace pavo::test {
namespace {

using testing::HasSubstr;

std::string write_twice(const Recording& recording) {
  const std::string once = recording.out("once.ts"), twice = recording.out("twice.ts");
  cv::VideoWriter writer(once, cv::CAP_FFMPEG, cv::VideoWriter::fourcc('m', 'p', 'g', '2'), 10, {320, 96});
  if (!writer.isOpened()) return {};
  for (int i = 0; i < kFrames; ++i) writer.write(cv::imread(recording.image(i), cv::IMREAD_COLOR));
  writer.release();
  std::ofstream(twice, std::ios::binary) << bytes_of(once) << bytes_of(once);
  return twice;
}

TEST(VideosWithWrongTimes, AreUsedAndWarnedOf) {
  const Recording recording;
  const std::string video = write_twice(recording), calibration = recording.file("calib.txt");
  if (video.empty()) GTEST_SKIP() << "OpenCV's videoio cannot write a video here (no FFmpeg)";

  const Called run = pavo({"run", video, "--calibration", calibration, "--no-people", "--out", recording.out()});
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.error, testing::AllOf(IsOneLine(), HasSubstr("12 times are missing or do not increase")));
  EXPECT_EQ(report_of(recording.out())["warnings"].size(), 1u);
  expect_complete(recording.out());

  const Called record = pavo({"record", video, "--calibration", calibration, "--out", recording.out("recorded")});
  EXPECT_EQ(record.status, 0);
  EXPECT_THAT(record.error, testing::AllOf(IsOneLine(), HasSubstr("12 frames had no time or one that did not")));
}

}  // namespace
}  // namespace pavo::test
