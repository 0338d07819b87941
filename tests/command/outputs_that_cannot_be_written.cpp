// OUT that is there, that is a file, that fills up: nothing stale is left, nothing that was written is lost.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/command/command.h"

namespace pavo::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

namespace fs = std::filesystem;

TEST(Outputs, OfAnEarlierRunWithOtherOptionsAreGone) {
  const Recording recording;
  ASSERT_EQ(pavo({"run", recording.path(), "--out", recording.out(), "--compare"}).status, 0);
  for (const char* name : {"people.csv", "trajectory.geometric.kitti", "report.json"})
    EXPECT_TRUE(fs::exists(recording.out() + "/" + name)) << name;
  std::ofstream(recording.out() + "/mine.txt") << "kept";
  fs::resize_file(recording.image(0), 0);
  ASSERT_EQ(pavo(recording.run({"--groundtruth", "none"})).status, 0);
  EXPECT_FALSE(fs::exists(recording.out() + "/people.csv"));
  EXPECT_FALSE(fs::exists(recording.out() + "/trajectory.geometric.kitti"));
  EXPECT_EQ(bytes_of(recording.out() + "/mine.txt"), "kept");
  EXPECT_FALSE(report_of(recording.out()).contains("accuracy"));
  expect_complete(recording.out());
}

TEST(Outputs, AreMadeWithTheFoldersAboveThem) {
  const Recording recording;
  ASSERT_EQ(pavo({"run", recording.path(), "--no-people", "--out", recording.out("a/b/c")}).status, 0);
  expect_complete(recording.out("a/b/c"));
}

TEST(Outputs, InOrBelowAFileAreRefused) {
  const Recording recording;
  const std::string times = bytes_of(recording.file("times.txt"));
  for (const std::string& out : {recording.file("times.txt"), recording.file("times.txt/deeper")}) {
    const Called called = pavo({"run", recording.path(), "--no-people", "--out", out});
    EXPECT_EQ(called.status, 1);
    EXPECT_THAT(called.error, AllOf(IsOneLine(), HasSubstr("--out " + out), HasSubstr("cannot be made")));
  }
  EXPECT_EQ(bytes_of(recording.file("times.txt")), times);
}

TEST(Outputs, InAFolderWithoutPermissionAreRefused) {
  const Recording recording;
  fs::create_directory(recording.out());
  fs::permissions(recording.out(), fs::perms::owner_read | fs::perms::owner_exec);
  if (std::ofstream(recording.out() + "/probe").good()) GTEST_SKIP() << "this user may write where nobody may";
  const Called called = pavo(recording.run());
  EXPECT_EQ(called.status, 1);
  EXPECT_THAT(called.error, AllOf(IsOneLine(), HasSubstr("Permission denied")));
}

// A limit on the size of files fails as a full disk does, in the middle of a line.
TEST(Outputs, OnAFullDiskEndWithWholeLines) {
  const Recording recording;
  recording.make_long(40);
  const Called called = pavo(recording.run(), "trap '' XFSZ; ulimit -f 4");  // blocks of 512 bytes
  EXPECT_EQ(called.status, 1);
  EXPECT_THAT(called.error,
              AllOf(IsOneLine(), StartsWith("pavo: " + recording.out() + "/"), HasSubstr("File too large")));
  const std::string bytes = bytes_of(recording.out() + "/trajectory.kitti");
  EXPECT_GT(bytes.size(), 1000u);
  EXPECT_LE(bytes.size(), 2048u);
  EXPECT_EQ(bytes.back(), '\n');
  EXPECT_FALSE(fs::exists(recording.out() + "/report.json.part"));
}

TEST(Outputs, AreWrittenWhereThereIsNoPeopleNoTruthAndNoTimes) {
  const Recording recording;
  recording.remove("times.txt");
  recording.remove("poses.txt");
  const Called called = pavo(recording.run());
  EXPECT_EQ(called.status, 0) << called.error;
  EXPECT_EQ(called.error, "");
  expect_complete(recording.out());
}

}  // namespace
}  // namespace pavo::test
