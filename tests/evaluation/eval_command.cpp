// `pavo eval` as it is called: what it prints, writes and refuses.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "drivers/trajectories/trajectory_files.h"
#include "tests/evaluation/paths.h"
#include "tests/support/temporary.h"
#include "tools/pavo/eval.h"

namespace pavo {
namespace {

using namespace test;
using ::testing::HasSubstr;
using ::testing::Not;

struct Called {
  int status = -1;
  std::string out;
  std::string error;
  bool wrong_call = false;
};

Called pavo(std::vector<std::string> arguments) {
  Called called;
  CLI::App app("pavo");
  register_eval(app, called.status);
  std::reverse(arguments.begin(), arguments.end());
  ::testing::internal::CaptureStdout();
  try {
    app.parse(arguments);
  } catch (const CLI::ParseError& error) {
    called.wrong_call = true;
    called.error = error.what();
  } catch (const std::exception& error) {
    called.error = error.what();
  }
  called.out = ::testing::internal::GetCapturedStdout();
  return called;
}

class EvalCommand : public ::testing::Test {
 protected:
  EvalCommand() {
    truth = folder.file("poses.txt");
    estimate = folder.file("trajectory.kitti");
    write_kitti_poses(truth, straight(301));
    write_kitti_poses(estimate, straight(301, 1.25));
  }
  TemporaryFolder folder;
  std::string truth, estimate;
};

TEST_F(EvalCommand, PrintsTheTables) {
  const Called called = pavo({"eval", estimate, truth});
  EXPECT_EQ(called.status, 0) << called.error;
  for (const char* part : {"301 poses compared by number", "ATE (m)", "* Sim(3)", "0.8000", "t_rel %", "100 m", "200 m",
                           "25.25", "RPE per frame", "RMSE of the poses", "RMSE of the motions", "every 10th frame"})
    EXPECT_THAT(called.out, HasSubstr(part));
  EXPECT_THAT(called.out, Not(HasSubstr("nan")));
}

TEST_F(EvalCommand, WritesEveryNumberAsJson) {
  const Called called =
      pavo({"eval", estimate, truth, truth, "--json", folder.file("e.json"), "--step", "1", "--align", "se3"});
  ASSERT_EQ(called.status, 0) << called.error;
  const auto json = nlohmann::json::parse(bytes_of(folder.file("e.json")));
  EXPECT_EQ(json["step"], 1);
  EXPECT_EQ(json["align"], "se3");
  ASSERT_EQ(json["estimates"].size(), 2u);
  const auto& e = json["estimates"][0];
  EXPECT_EQ(e["file"], estimate);
  EXPECT_NEAR(e["ate_m"]["sim3"]["scale"], 0.8, 1e-9);
  EXPECT_TRUE(e["ate_m"]["se3"]["scale"].is_null());
  EXPECT_NEAR(e["ate_m"]["none"]["max"], 75, 1e-6);
  EXPECT_NEAR(e["raw"]["motion_rmse"][2][3], 0.25, 1e-6);
  EXPECT_EQ(e["raw"]["pose_rmse"].size(), 3u);
  EXPECT_EQ(e["raw"]["pose_rmse"][0].size(), 4u);
  EXPECT_EQ(e["raw"]["segments"]["lengths"].size(), 8u);
  EXPECT_EQ(e["raw"]["segments"]["lengths"][0]["segments"], 200);
  EXPECT_EQ(e["raw"]["segments"]["lengths"][7]["segments"], 0);
  EXPECT_TRUE(e["raw"]["segments"]["lengths"][7]["t_rel_percent"].is_null());
  EXPECT_NEAR(e["scaled"]["segments"]["t_rel_percent"], 0, 1e-6);
  EXPECT_THAT(called.out, HasSubstr("ATE: rmse, aligned by SE(3)"));
}

TEST_F(EvalCommand, DrawsTheAlignedPaths) {
  const Called called = pavo({"eval", estimate, truth, "--plot", folder.file("p.svg")});
  ASSERT_EQ(called.status, 0) << called.error;
  const std::string svg = bytes_of(folder.file("p.svg"));
  EXPECT_THAT(svg, HasSubstr("aligned to the ground truth by Sim(3)"));
  EXPECT_THAT(svg, HasSubstr("trajectory.kitti"));
  EXPECT_THAT(svg, HasSubstr("#d62728"));
}

TEST_F(EvalCommand, SaysDashAndNullWhereNothingMoves) {
  write_kitti_poses(truth, repeated({}, 301));
  const Called called =
      pavo({"eval", estimate, truth, "--json", folder.file("e.json"), "--plot", folder.file("p.svg")});
  ASSERT_EQ(called.status, 0) << called.error;
  EXPECT_THAT(called.out, ::testing::ContainsRegex("all +- +- +- +0"));
  EXPECT_THAT(called.out, HasSubstr("no scale: a path stands still"));
  const auto e = nlohmann::json::parse(bytes_of(folder.file("e.json")))["estimates"][0];
  EXPECT_TRUE(e["scaled"].is_null());
  EXPECT_TRUE(e["raw"]["segments"]["t_rel_percent"].is_null());
  EXPECT_EQ(e["raw"]["segments"]["segments"], 0);
}

TEST_F(EvalCommand, FindsAPartOfKittisFramesByTheTimesBesideThePoses) {
  std::string times;
  Trajectory part;
  for (int i = 0; i < 301; ++i) times += std::to_string(0.1 * i) + "\n";
  for (std::size_t i = 20; i < 200; i += 2) {
    part.T_w_c.push_back(straight(301).T_w_c[i]);
    part.t_ns.push_back(static_cast<std::int64_t>(i) * 100'000'000);
  }
  write_tum(folder.file("part.tum"), part);
  EXPECT_THAT(pavo({"eval", folder.file("part.tum"), truth}).error,
              HasSubstr("the estimate has 90 poses, the ground truth 301"));
  folder.write("times.txt", times);
  const Called called = pavo({"eval", folder.file("part.tum"), truth});
  EXPECT_EQ(called.status, 0) << called.error;
  EXPECT_THAT(called.out, HasSubstr("90 poses compared by time (of 90 and 301)"));
  folder.write("times.txt", "0\n1\n");
  EXPECT_THAT(pavo({"eval", folder.file("part.tum"), truth}).error, HasSubstr("times.txt: 2 times for the 301 poses"));
}

TEST_F(EvalCommand, RefusesInOneLineWhatIsWrong) {
  EXPECT_EQ(pavo({"eval", folder.file("none"), truth}).error,
            folder.file("none") + ": cannot be read: No such file or directory");
  const std::string bad = folder.write("bad.txt", "1 0 0 0 0 1 0 0 0 0 1 nan\n");
  EXPECT_THAT(pavo({"eval", bad, truth}).error, HasSubstr("bad.txt:1: expected a finite number"));
  write_kitti_poses(estimate, straight(300));
  const std::string counts = pavo({"eval", estimate, truth}).error;
  EXPECT_THAT(counts, HasSubstr(estimate + " against " + truth + ": the estimate has 300 poses"));
  EXPECT_EQ(counts.find('\n'), std::string::npos);
  write_kitti_poses(estimate, straight(301));
  EXPECT_THAT(pavo({"eval", estimate, truth, "--json", folder.file("no/e.json")}).error,
              HasSubstr("no/e.json: cannot be written"));
  EXPECT_THAT(pavo({"eval", estimate, truth, "--plot", folder.file("no/p.svg")}).error,
              HasSubstr("no/p.svg: cannot be written"));
}

TEST_F(EvalCommand, RefusesAWrongCall) {
  for (const auto& arguments : std::vector<std::vector<std::string>>{{"eval"},
                                                                     {"eval", estimate},
                                                                     {"eval", estimate, truth, "--align", "sim4"},
                                                                     {"eval", estimate, truth, "--step", "0"},
                                                                     {"eval", estimate, truth, "--step", "x"},
                                                                     {"eval", estimate, truth, "--nonsense"}}) {
    const Called called = pavo(arguments);
    EXPECT_TRUE(called.wrong_call) << arguments.back();
    EXPECT_EQ(called.status, -1);
  }
}

}  // namespace
}  // namespace pavo
