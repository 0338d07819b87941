// --live: the books balance, every frame has its line. --draw: a picture a frame, or a film.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "tests/command/command.h"

namespace pavo::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(LiveRuns, GiveEveryFrameItsLine) {
  const Recording recording;
  const Called called = pavo(recording.run({"--live"}));
  EXPECT_EQ(called.status, 0) << called.error;
  expect_complete(recording.out());
  const auto report = report_of(recording.out());
  EXPECT_EQ(report["frames"]["in"], kFrames);
  EXPECT_EQ(report["config"]["source"]["mode"], "live");
}

TEST(LiveRuns, DropWhatComesTooFast) {
  const Recording recording;
  recording.make_long(300);
  recording.remove("times.txt");
  const Called called = pavo(recording.run({"--live", "--rate", "5000", "--workers", "1", "--compare"}));
  EXPECT_EQ(called.status, 0) << called.error;
  expect_complete(recording.out());
  const auto report = report_of(recording.out());
  EXPECT_EQ(report["frames"]["in"], 300);
  EXPECT_GT(report["frames"]["dropped"], 0);
  EXPECT_EQ(report["frames"]["dropped"], report["frames"]["dropped_by"]["replaced"]);
  bool told = false;
  for (const auto& row : rows_of(recording.out() + "/frames.csv")) {
    if (row[2] != "dropped") continue;
    told = true;
    EXPECT_EQ(row[3], "replaced by a newer frame");
  }
  EXPECT_TRUE(told);
}

TEST(LiveRuns, CountBrokenFramesToo) {
  const Recording recording;
  for (const int i : {0, 4, 11}) std::ofstream(recording.image(i)) << "broken";
  const Called called = pavo(recording.run({"--live"}));
  EXPECT_EQ(called.status, 0) << called.error;
  expect_complete(recording.out());
}

TEST(DrawnRuns, HaveAPictureOfEveryFrame) {
  const Recording recording;
  std::ofstream(recording.image(5)) << "broken";
  const Called called = pavo({"run", recording.path(), "--draw", recording.out("drawn"), "--workers", "3"});
  EXPECT_EQ(called.status, 0) << called.error;
  int pictures = 0;
  for (const auto& entry : std::filesystem::directory_iterator(recording.out("drawn"))) {
    ++pictures;
    EXPECT_FALSE(cv::imread(entry.path().string()).empty()) << entry.path();
  }
  EXPECT_EQ(pictures, kFrames);
  EXPECT_EQ(cv::imread(recording.out("drawn") + "/000003.jpg").size(), cv::Size(320, 96));
}

// Of the frames' rate, to a hundredth: MPEG-4 cannot count time in 89847 parts.
class DrawnRunsOfAPeriod : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(DrawnRuns, DrawnRunsOfAPeriod, testing::Values(0.05, 0.01113));

TEST_P(DrawnRunsOfAPeriod, MakeAFilm) {
  const Recording recording;
  recording.make_long(kFrames);
  std::string times;
  for (int i = 0; i < kFrames; ++i) times += std::to_string(GetParam() * i) + "\n";
  recording.write("times.txt", times);
  const std::string film = recording.out("film.mp4");
  std::ofstream(recording.image(0)) << "broken";  // the first picture has no size of its own
  const Called called = pavo(recording.run({"--draw", film}));
  EXPECT_EQ(called.status, 0) << called.error;
  EXPECT_THAT(called.error, IsOneLine()) << "the warning, and nothing of the encoder's";
  cv::VideoCapture video(film, cv::CAP_FFMPEG);
  ASSERT_TRUE(video.isOpened());
  int frames = 0;
  for (cv::Mat picture; video.read(picture); ++frames) EXPECT_EQ(picture.size(), cv::Size(320, 96));
  EXPECT_EQ(frames, kFrames);
  EXPECT_NEAR(video.get(cv::CAP_PROP_FPS), 1 / GetParam(), 0.01);
}

// FFmpeg tells nobody that the disk is full.
TEST(DrawnRuns, FilmsThatAreNotWholeAreTold) {
  const Recording recording;
  const std::string film = recording.out("film.mp4");
  const Called called = pavo({"run", recording.path(), "--no-people", "--draw", film}, "trap '' XFSZ; ulimit -f 16");
  EXPECT_EQ(called.status, 1);
  EXPECT_THAT(called.error, AllOf(IsOneLine(), HasSubstr("film.mp4 is incomplete")));
}

TEST(DrawnRuns, DoNotOverwriteTheRecordingsPictures) {
  const Recording recording;
  const Called called = pavo(recording.run({"--draw", recording.file("image_0")}));
  EXPECT_EQ(called.status, 2);
  EXPECT_THAT(called.error, AllOf(IsOneLine(), HasSubstr("--draw"), HasSubstr("would be overwritten")));
  EXPECT_FALSE(std::filesystem::exists(recording.file("image_0/000000.jpg")));
  EXPECT_EQ(pavo(recording.run({"--draw", recording.file("drawn")})).status, 0) << "a folder of its own may be there";
}

TEST(DrawnRuns, ThatCannotBeWrittenKeepTheOtherOutputs) {
  const Recording recording;
  for (const std::string& where :
       {std::string("/proc/nothing"), recording.file("calib.txt"), recording.file("calib.txt") + "/x.mp4",
        std::string("/proc/x.mp4"), recording.out("film.avi")}) {
    const Called called = pavo(recording.run({"--draw", where}));
    EXPECT_EQ(called.status, 1) << where;
    EXPECT_THAT(called.error, AllOf(IsOneLine(), HasSubstr("--draw"), HasSubstr(where)));
  }
  expect_complete(recording.out());
}

}  // namespace
}  // namespace pavo::test
