// `pavo run` on a street with people in it: who is seen is written, what is on them is dropped, and counted alike
// everywhere.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "drivers/synthetic/write_kitti.h"
#include "tests/command/command.h"

namespace pavo::test {
namespace {

/// Ten frames with people who walk along with the camera, rendered once a process.
const std::string& crowded_street() {
  static const TemporaryFolder folder;
  static const std::string path = [] {
    SyntheticOptions options;
    options.frames = 10;
    options.width = 480;
    options.height = 200;
    options.companions = 3;
    write_kitti_folder(options, folder.file("street"));
    return folder.file("street");
  }();
  return path;
}

class WithPeople : public testing::TestWithParam<const char*> {
 protected:
  Called run(const std::string& name, Words more = {}) const {
    Words words{"run", crowded_street(), "--out", out(name), "--estimator", GetParam()};
    words.insert(words.end(), more.begin(), more.end());
    return pavo(words);
  }
  std::string out(const std::string& name) const { return folder_.file(name); }

  TemporaryFolder folder_;
};

long sum_of_column(const std::string& csv, const std::string& column) {
  const auto rows = rows_of(csv);
  const auto at = std::find(rows[0].begin(), rows[0].end(), column) - rows[0].begin();
  long sum = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) sum += std::stol(rows[i].at(static_cast<std::size_t>(at)));
  return sum;
}

TEST_P(WithPeople, TheirFeaturesAreDroppedAndCounted) {
  const Called called = run("out");
  ASSERT_EQ(called.status, 0) << called.error;
  expect_complete(out("out"));
  const nlohmann::json people = report_of(out("out")).at("people");
  EXPECT_GT(people.at("seen"), 0);
  EXPECT_EQ(people.at("seen"), rows_of(out("out") + "/people.csv").size() - 1);
  EXPECT_GT(people.at("features_dropped"), 0);
  EXPECT_EQ(people.at("features_dropped"), sum_of_column(out("out") + "/frames.csv", "dropped_on_people"));
  for (const auto& row : rows_of(out("out") + "/people.csv")) {
    if (row[0] == "frame") continue;
    EXPECT_GE(std::stod(row[4]), 60) << "the height of a person's box";
    EXPECT_GT(std::stod(row[5]), 0);
    EXPECT_LE(std::stod(row[5]), 1) << "a probability";
  }
}

TEST_P(WithPeople, NobodyIsLookedForWhereThatIsAsked) {
  const Called called = run("out", {"--no-people"});
  ASSERT_EQ(called.status, 0) << called.error;
  EXPECT_FALSE(std::filesystem::exists(out("out") + "/people.csv"));
  EXPECT_EQ(sum_of_column(out("out") + "/frames.csv", "dropped_on_people"), 0);
}

TEST_P(WithPeople, TheResultDoesNotDependOnTheWorkers) {
  std::string sha;
  for (const char* workers : {"1", "2", "3"}) {
    ASSERT_EQ(run(workers, {"--workers", workers}).status, 0);
    const std::string now = report_of(out(workers)).at("trajectory_sha256");
    if (sha.empty()) sha = now;
    EXPECT_EQ(now, sha) << workers << " workers";
  }
}

INSTANTIATE_TEST_SUITE_P(Estimators, WithPeople, testing::Values("keyframe", "frame-to-frame"), [](const auto& i) {
  return std::string(i.param) == "keyframe" ? "Keyframe" : "FrameToFrame";
});

// The third curve of the thesis: plain geometry beside it in the same run.
TEST(WithPeople, PlainGeometryRunsBeside) {
  const TemporaryFolder folder;
  const std::string out = folder.file("out");
  const Called called = pavo({"run", crowded_street(), "--out", out, "--compare", "--scale", "groundtruth"});
  ASSERT_EQ(called.status, 0) << called.error;
  EXPECT_THAT(called.out, testing::HasSubstr("without removing people"));
  EXPECT_THAT(bytes_of(out + "/trajectory.svg"), testing::HasSubstr("geometric"));
}

}  // namespace
}  // namespace pavo::test
