// Every file of `pavo run --out`, in the form that the documentation promises.
#include <gtest/gtest.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/command/command.h"

namespace pavo::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::StartsWith;

class Letter : public ::testing::Test {
 protected:
  void run(const Words& more) const {
    Words words{"run", recording.path(), "--out", recording.out()};
    words.insert(words.end(), more.begin(), more.end());
    const Called called = pavo(words);
    ASSERT_EQ(called.status, 0) << called.error;
    EXPECT_EQ(called.error, "");
    expect_complete(recording.out());
  }
  std::string out(const std::string& name) const { return recording.out() + "/" + name; }
  Recording recording;
};

std::string output_of(const std::string& shell) {
  std::string text;
  FILE* pipe = ::popen(shell.c_str(), "r");
  for (int c; pipe && (c = std::fgetc(pipe)) != EOF;) text += static_cast<char>(c);
  if (pipe) ::pclose(pipe);
  return text;
}

TEST_F(Letter, TrajectoriesStartAtTheIdentityAndAgree) {
  run({"--no-people"});
  const auto kitti = lines_of(out("trajectory.kitti")), tum = lines_of(out("trajectory.tum"));
  const std::string o = "0.000000000e+00", i = "1.000000000e+00";
  EXPECT_EQ(kitti[0], i + " " + o + " " + o + " " + o + " " + o + " " + i + " " + o + " " + o + " " + o + " " + o +
                          " " + i + " " + o);
  for (std::size_t n = 0; n < kitti.size(); ++n) {
    EXPECT_THAT(kitti[n], MatchesRegex("(-?[0-9]\\.[0-9]{9}e[+-][0-9]{2} ?){12}")) << kitti[n];
    std::istringstream k(kitti[n]), t(tum[n]);
    double pose[12], time, position[3];
    for (double& v : pose) k >> v;
    t >> time >> position[0] >> position[1] >> position[2];
    EXPECT_NEAR(time, 0.1 * static_cast<double>(n), 1e-6);
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_EQ(position[axis], pose[4 * axis + 3]);
    EXPECT_EQ(std::count(tum[n].begin(), tum[n].end(), ' '), 7);
  }
}

TEST_F(Letter, TablesHaveTheirColumns) {
  run({});
  const auto frames = rows_of(out("frames.csv")), people = rows_of(out("people.csv"));
  EXPECT_THAT(frames[0], ElementsAre("frame", "timestamp_s", "status", "reason", "quality", "keypoints",
                                     "dropped_on_people", "matches", "inliers"));
  EXPECT_EQ(frames[2][1], "0.100000000");
  EXPECT_THAT(people[0], ElementsAre("frame", "x", "y", "width", "height", "score"));
  EXPECT_EQ(report_of(recording.out())["people"]["seen"], people.size() - 1);
}

TEST_F(Letter, TimesAreExactThroughout) {
  std::string times;
  for (int i = 0; i < kFrames; ++i) times += "1403715273." + std::to_string(262142976 + 50'000'000 * i) + "\n";
  recording.write("times.txt", times);
  run({"--no-people"});
  EXPECT_EQ(rows_of(out("frames.csv"))[1][1], "1403715273.262142976");
  EXPECT_THAT(lines_of(out("trajectory.tum"))[0], StartsWith("1403715273.262142976 "));
}

TEST_F(Letter, TheReportHasEveryKey) {
  run({"--seed", "7", "--workers", "3"});
  const nlohmann::json report = report_of(recording.out());
  for (const char* key : {"frames", "wall_s", "fps", "latency_ms", "stages", "estimator", "scale", "simd", "people",
                          "trajectory_sha256", "versions", "config"})
    EXPECT_TRUE(report.contains(key)) << key;
  const auto expect_quantiles = [](const nlohmann::json& q, const std::string& where) {
    ASSERT_TRUE(q.is_object()) << where;
    for (const char* key : {"p50", "p90", "p99", "p999", "max"}) ASSERT_TRUE(q.contains(key)) << where << " " << key;
    EXPECT_LE(q["p50"], q["p90"]) << where;
    EXPECT_LE(q["p999"], q["max"].get<double>() * 1.01) << where;
  };
  for (const char* name : {"end_to_end", "age"}) expect_quantiles(report["latency_ms"][name], name);
  for (const char* stage : {"decode", "features", "scan", "people", "odometry"}) {
    ASSERT_TRUE(report["stages"].contains(stage)) << stage;
    for (const char* what : {"wait_ms", "service_ms", "cpu_ms"}) expect_quantiles(report["stages"][stage][what], stage);
  }
  EXPECT_FALSE(report["stages"].contains("undistort")) << "a rectified source passes untouched";
  EXPECT_EQ(report["frames"]["in"], kFrames);
  EXPECT_EQ(report["frames"]["done"], kFrames);
  EXPECT_EQ(report["estimator"], "keyframe");
  EXPECT_EQ(report["scale"], "unit");
  EXPECT_TRUE(report["people"].contains("seen") && report["people"].contains("features_dropped"));
  EXPECT_EQ(report["config"]["odometry"]["seed"], 7);
  EXPECT_EQ(report["config"]["engine"]["workers"], 3);
  EXPECT_EQ(report["source"]["calibration"], recording.file("calib.txt") + ", P0");
  EXPECT_EQ(output_of("sha256sum <" + out("trajectory.kitti")).substr(0, 64), report["trajectory_sha256"]);
}

TEST_F(Letter, OptionsWinOverTheFileAndTheFileOverDefaults) {
  recording.write("c.toml", "[odometry]\nseed = 3\nmin_matches = 15\n[features]\nmax_features = 500\n");
  run({"--no-people", "--config", recording.file("c.toml"), "--seed", "4", "--simd", "SSE4"});
  const nlohmann::json report = report_of(recording.out());
  EXPECT_EQ(report["config"]["odometry"]["seed"], 4);
  EXPECT_EQ(report["config"]["odometry"]["min_matches"], 15);
  EXPECT_EQ(report["config"]["features"]["max_features"], 500);
  EXPECT_EQ(report["config"]["odometry"]["match_ratio"], 0.85);
  EXPECT_EQ(report["simd"], "SSE4");
}

/// The elements' names in order of their ends, or "" where a tag is left open or closed wrongly.
bool is_well_formed(const std::string& xml) {
  std::vector<std::string> open;
  for (std::size_t at = 0; (at = xml.find('<', at)) != std::string::npos;) {
    const std::size_t end = xml.find('>', at);
    if (end == std::string::npos) return false;
    const std::string tag = xml.substr(at + 1, end - at - 1);
    at = end;
    if (tag.empty() || tag.find('<') != std::string::npos) return false;
    if (std::count(tag.begin(), tag.end(), '"') % 2 != 0) return false;
    if (tag[0] == '?' || tag[0] == '!') continue;
    const std::string name = tag.substr(tag[0] == '/', tag.find_first_of(" \n/", 1) - (tag[0] == '/'));
    if (tag[0] == '/') {
      if (open.empty() || open.back() != name) return false;
      open.pop_back();
    } else if (tag.back() != '/') {
      open.push_back(name);
    }
  }
  return open.empty() && !xml.empty();
}

TEST_F(Letter, ThePictureHasTheThreeCurves) {
  run({"--no-people", "--compare", "--scale", "groundtruth"});
  const std::string svg = bytes_of(out("trajectory.svg"));
  EXPECT_TRUE(is_well_formed(svg)) << svg;
  for (const char* color : {"#d62728", "#2ca02c", "#1f5fd0"}) EXPECT_THAT(svg, HasSubstr(color));
  for (const char* label : {"ground truth", "geometric", "pavo", "SE(3)"}) EXPECT_THAT(svg, HasSubstr(label));
  EXPECT_EQ(lines_of(out("trajectory.geometric.kitti")).size(), static_cast<std::size_t>(kFrames));
  EXPECT_THAT(std::string(report_of(recording.out())["scale"]), StartsWith("groundtruth"));
}

TEST_F(Letter, ThePictureOfAStrangelyNamedSourceIsWellFormedToo) {
  const std::string strange = recording.out("a <b> & \"c\"");
  std::filesystem::rename(recording.path(), strange);
  const Called called = pavo({"run", strange, "--out", recording.out(), "--no-people"});
  ASSERT_EQ(called.status, 0) << called.error;
  EXPECT_TRUE(is_well_formed(bytes_of(out("trajectory.svg"))));
  EXPECT_EQ(report_of(recording.out())["source"]["path"], strange);
}

TEST_F(Letter, AMetricScaleIsMetric) {
  std::string speed;
  for (int i = 0; i <= kFrames; ++i) speed += std::to_string(0.1 * i) + ",8\n";
  recording.write("speed.csv", speed);
  run({"--no-people", "--estimator", "frame-to-frame", "--scale", "speed=" + recording.file("speed.csv")});
  const nlohmann::json report = report_of(recording.out());
  EXPECT_NEAR(report["accuracy"]["length_m"], 0.8 * (kFrames - 1), 1e-6);
}

TEST_F(Letter, ADistortedSourceIsUndistorted) {
  const Words synth{"synth", "--out",  recording.out("bent"), "--frames", "6", "--width", "320", "--height",
                    "96",    "--lens", "radial-tangential"};
  ASSERT_EQ(pavo(synth).status, 0);
  const Called called = pavo({"run", recording.out("bent"), "--out", recording.out(), "--no-people", "--calibration",
                              recording.out("bent") + "/camera.yaml", "--alpha", "0.5"});
  ASSERT_EQ(called.status, 0) << called.error;
  expect_complete(recording.out());
  EXPECT_TRUE(report_of(recording.out())["stages"].contains("undistort"));
}

}  // namespace
}  // namespace pavo::test
