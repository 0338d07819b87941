// A frame that is broken fails, is counted and named, and the run goes on; where none can be used, it ends with 1.
#include <sys/stat.h>

#include <nlohmann/json.hpp>

#include "tests/command/command.h"

namespace pavo::test {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::StartsWith;

namespace fs = std::filesystem;

class BrokenFrames : public ::testing::Test {
 protected:
  /// Runs, and expects that exactly these frames failed, with these words in their reasons.
  void expect_failed(const std::vector<std::pair<int, std::string>>& failed, const Words& more = {}) const {
    const Called called = pavo(recording.run(more));
    EXPECT_EQ(called.status, 0) << called.error;
    EXPECT_THAT(called.error,
                AllOf(IsOneLine(), StartsWith("pavo: warning: " + std::to_string(failed.size()) + " of 12 frames"),
                      HasSubstr("frame " + std::to_string(failed.front().first)), HasSubstr(failed.front().second)));
    expect_complete(recording.out());
    const auto report = report_of(recording.out());
    EXPECT_EQ(report["frames"]["failed"], failed.size());
    EXPECT_EQ(report["warnings"].size(), 1u);
    const auto rows = rows_of(recording.out() + "/frames.csv");
    ASSERT_EQ(rows.size(), kFrames + 1u);
    for (const auto& [frame, reason] : failed) {
      const auto& row = rows[static_cast<std::size_t>(frame) + 1];
      EXPECT_EQ(row[2], "failed");
      EXPECT_THAT(row[3], HasSubstr(reason));
      EXPECT_EQ(row[4], "coasting");
    }
  }
  void cut(int frame, std::uintmax_t bytes) const { fs::resize_file(recording.image(frame), bytes); }
  void replace(int frame, const std::string& bytes) const {
    std::ofstream(recording.image(frame), std::ios::binary) << bytes;
  }
  Recording recording;
};

TEST_F(BrokenFrames, TruncatedCorruptEmptyAndMissing) {
  cut(3, 1000);
  std::string png = bytes_of(recording.image(5));
  for (std::size_t i = png.size() / 2; i < png.size() / 2 + 100; ++i) png[i] = static_cast<char>(~png[i]);
  replace(5, png);
  cut(7, 0);
  replace(8, "this is no picture");
  fs::remove(recording.image(10));
  fs::create_symlink("nowhere.png", recording.image(10));
  expect_failed({{3, "decode"}, {5, "decode"}, {7, "is empty"}, {8, "no image"}, {10, "No such file"}});
}

TEST_F(BrokenFrames, OfAnotherSize) {
  replace(6, "P5 8 4 255\n" + std::string(32, 'x'));
  expect_failed({{6, "the frame is 8x4, expected "}});
  replace(6, "P5 99999 99999 255\n" + std::string(32, 'x'));
  expect_failed({{6, "99999x99999"}});
}

TEST_F(BrokenFrames, TheFirstAndTheLast) {
  cut(0, 100);
  cut(11, 100);
  expect_failed({{0, "decode"}, {11, "decode"}});
  const auto poses = lines_of(recording.out() + "/trajectory.kitti");
  EXPECT_THAT(poses[0], StartsWith("1.000000000e+00 0.000000000e+00"));
}

TEST_F(BrokenFrames, AFolderOrAPipeInTheirPlace) {
  fs::remove(recording.image(2));
  fs::create_directory(recording.image(2));
  fs::remove(recording.image(4));
  ASSERT_EQ(::mkfifo(recording.image(4).c_str(), 0600), 0);
  expect_failed({{2, "no regular file"}, {4, "no regular file"}});
}

TEST_F(BrokenFrames, UnreadableOnes) {
  fs::permissions(recording.image(4), fs::perms::none);
  if (std::ifstream(recording.image(4)).good()) GTEST_SKIP() << "this user may read what nobody may";
  expect_failed({{4, "Permission denied"}});
}

TEST_F(BrokenFrames, WithKltToo) {
  cut(4, 500);
  cut(5, 500);
  expect_failed({{4, "decode"}, {5, "decode"}}, {"--tracker", "klt", "--compare"});
}

TEST_F(BrokenFrames, AllOfThemAreAnError) {
  for (int i = 0; i < kFrames; ++i) cut(i, 1000);
  const Called called = pavo(recording.run());
  EXPECT_EQ(called.status, 1);
  EXPECT_THAT(called.error,
              AllOf(IsOneLine(), HasSubstr(recording.path()), HasSubstr("not one frame"), HasSubstr("000000.png")));
  expect_complete(recording.out());
  for (int i = 0; i < kFrames; ++i) replace(i, "none");
  EXPECT_THAT(pavo(recording.run()).error, AllOf(IsOneLine(), HasSubstr("000000.png: is no image")));
}

TEST_F(BrokenFrames, TooManyInARowEndTheRunAndLoseNothing) {
  recording.make_long(60);
  for (int i = 1; i < kFrames; ++i)
    fs::resize_file(recording.file("seen/" + fs::path(recording.image(i)).filename().string()), 900);
  recording.write("c.toml", "[engine]\nfailures_in_a_row = 10\n");
  const Called called = pavo(recording.run({"--config", recording.file("c.toml")}));
  EXPECT_EQ(called.status, 1);
  EXPECT_THAT(called.error, AllOf(IsOneLine(), HasSubstr("10 frames failed in a row, the last in decode")));
  expect_complete(recording.out());
  EXPECT_EQ(report_of(recording.out())["frames"]["dropped"], 0);
}

TEST_F(BrokenFrames, BlackAndConstantOnesArePosesToo) {
  for (int i = 4; i < 8; ++i) replace(i, "P5 320 96 255\n" + std::string(320 * 96, i % 2 ? '\0' : '\x80'));
  const Called called = pavo(recording.run());
  EXPECT_EQ(called.status, 0) << called.error;
  expect_complete(recording.out());
  const auto rows = rows_of(recording.out() + "/frames.csv");
  for (std::size_t i = 5; i < 8; ++i) EXPECT_EQ(rows[i][4], "coasting") << i - 1;
}

}  // namespace
}  // namespace pavo::test
