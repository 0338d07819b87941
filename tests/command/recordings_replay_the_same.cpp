// `pavo record` as a process, and `pavo run` on what it wrote.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "drivers/sequences/sequence.h"
#include "tests/command/command.h"

namespace pavo::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

namespace fs = std::filesystem;

std::size_t frames_in(const std::string& folder) {
  const auto sequence = open_sequence(folder);
  EncodedImage image;
  FrameStamp stamp;
  std::size_t frames = 0;
  while (sequence->read(image, stamp)) ++frames;
  return frames;
}

class Record : public ::testing::Test {
 protected:
  Words record(const Words& more = {}) const {
    Words words{"record", recording.path(), "--out", drive()};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  std::string trajectory_of(const std::string& source, const std::string& out) const {
    const Called called = pavo({"run", source, "--no-people", "--groundtruth", "none", "--out", recording.out(out)});
    EXPECT_EQ(called.status, 0) << called.error;
    return bytes_of(recording.out(out) + "/trajectory.tum");
  }
  std::string drive() const { return recording.out("drive"); }
  Recording recording;
};

TEST_F(Record, ReplaysToTheSameBitsInBothLayouts) {
  const std::string expected = trajectory_of(recording.path(), "a");
  for (const char* layout : {"euroc", "kitti"}) {
    fs::remove_all(drive());
    const Called called = pavo(record({"--layout", layout}));
    EXPECT_EQ(called.status, 0);
    EXPECT_EQ(called.error, "");
    EXPECT_THAT(called.out, AllOf(IsOneLine(), HasSubstr("12 frames written")));
    EXPECT_EQ(trajectory_of(drive(), "b"), expected) << layout;
    const auto report = nlohmann::json::parse(bytes_of(drive() + "/recording.json"));
    EXPECT_EQ(report["written"], kFrames);
    EXPECT_EQ(report["no_room"], 0);
  }
}

TEST_F(Record, KeepsTheLens) {
  ASSERT_EQ(pavo({"synth", "--out", recording.out("bent"), "--frames", "6", "--width", "320", "--height", "96",
                  "--lens", "equidistant"})
                .status,
            0);
  const std::string expected = trajectory_of(recording.out("bent"), "a");
  for (const char* layout : {"euroc", "kitti"}) {
    const std::string to = recording.out(layout);
    ASSERT_EQ(pavo({"record", recording.out("bent"), "--out", to, "--layout", layout}).status, 0);
    EXPECT_EQ(trajectory_of(to, "b"), expected) << layout;
  }
}

// Frames that are no image files yet: the renderer's.
TEST_F(Record, EncodesRawFramesWithoutLoss) {
  for (const char* image : {"png", "pgm"}) {
    const std::string to = recording.out(image);
    ASSERT_EQ(pavo({"record", "synthetic", "--out", to, "--image", image, "--frames", "3", "--encoders", "2"}).status,
              0);
    EXPECT_EQ(frames_in(to), 3u);
  }
  EXPECT_EQ(trajectory_of(recording.out("png"), "a"), trajectory_of(recording.out("pgm"), "b"));
}

TEST_F(Record, EndsCleanlyAtASignal) {
  recording.make_long(2000);
  Started started(record({"--live"}));
  ASSERT_TRUE(started.wait_for_lines(drive() + "/mav0/cam0/data.csv", 4));
  started.send(SIGINT);
  const Called called = started.wait();
  EXPECT_EQ(called.status, 0) << called.error;
  EXPECT_EQ(frames_in(drive()), lines_of(drive() + "/mav0/cam0/data.csv").size() - 1);
  EXPECT_TRUE(fs::exists(drive() + "/recording.json"));
}

TEST_F(Record, IsReadableWhenItWasKilled) {
  recording.make_long(2000);
  for (const char* layout : {"euroc", "kitti"}) {
    fs::remove_all(drive());
    Started started(record({"--layout", layout}));
    const std::string index = drive() + (std::string(layout) == "euroc" ? "/mav0/cam0/data.csv" : "/times.txt");
    ASSERT_TRUE(started.wait_for_lines(index, 20));
    started.send(SIGKILL);
    EXPECT_EQ(started.wait().status, 128 + SIGKILL);
    EXPECT_GE(frames_in(drive()), 15u) << layout;
    EXPECT_EQ(open_sequence(drive())->info().camera.has_value(), true);
  }
}

// A limit on the size of files fails as a full disk does.
TEST_F(Record, OnAFullDiskEndsWithAllBeforeReadable) {
  recording.make_long(100);
  // times.txt has 22 bytes a frame; the images are links to larger files, so let them be small ones.
  const Called called = pavo(record({"--layout", "euroc"}), "trap '' XFSZ; ulimit -f 32");  // blocks of 512 bytes
  EXPECT_EQ(called.status, 1);
  EXPECT_THAT(called.error, AllOf(IsOneLine(), StartsWith("pavo: "), HasSubstr("File too large")));
  EXPECT_FALSE(fs::exists(drive() + "/mav0/cam0/data.csv.part"));
  for (const auto& entry : fs::directory_iterator(drive() + "/mav0/cam0/data"))
    EXPECT_NE(entry.path().extension(), ".part");
}

TEST_F(Record, EndsAfterSoManyFrames) {
  ASSERT_EQ(pavo(record({"--frames", "5"})).status, 0);
  EXPECT_EQ(frames_in(drive()), 5u);
}

TEST_F(Record, RefusesWrongCallsAndBadSources) {
  const auto refused = [&](const Words& words, int status, const std::string& told) {
    const Called called = pavo(words);
    EXPECT_EQ(called.status, status) << ::testing::PrintToString(words);
    EXPECT_THAT(called.error, AllOf(IsOneLine(), StartsWith("pavo: "), HasSubstr(told)));
  };
  refused({"record", recording.path()}, 2, "--out is required");
  refused({"record", "", "--out", drive()}, 2, "SOURCE is empty");
  refused({"record", recording.path(), "--out", ""}, 2, "--out is empty");
  refused(record({"--layout", "tum"}), 2, "tum");
  refused(record({"--image", "jpg"}), 2, "jpg");
  refused(record({"--frames", "0"}), 2, "--frames");
  refused(record({"--seconds", "-1"}), 2, "--seconds");
  refused(record({"--encoders", "0"}), 2, "--encoders");
  refused(record({"--size", "640x480"}), 2, "--size is for cameras");
  refused({"record", "/dev/null", "--out", drive(), "--size", "640"}, 2, "--size must be WIDTHxHEIGHT");
  EXPECT_FALSE(fs::exists(drive()));
  refused({"record", "/dev/null", "--out", drive()}, 1, "/dev/null");
  refused({"record", "/dev/video-that-is-not-there", "--out", drive()}, 1, "/dev/video-that-is-not-there");
  refused({"record", recording.file("nothing"), "--out", drive()}, 1, "nothing");
  refused({"record", recording.path(), "--out", recording.path()}, 1, "is not empty");
  refused(record({"--calibration", recording.file("times.txt")}), 1, "times.txt");
  recording.remove("times.txt");
  refused(record(), 2, "--rate HZ");
  EXPECT_FALSE(fs::exists(drive()));
  EXPECT_EQ(pavo(record({"--rate", "20"})).status, 0);
}

}  // namespace
}  // namespace pavo::test
