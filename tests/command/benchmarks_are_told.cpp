// `pavo bench`: its figures are complete and in order, whatever they are; wrong calls and files end before anything is
// measured.
#include <cmath>
#include <nlohmann/json.hpp>

#include "drivers/trajectories/append_file.h"
#include "tests/command/command.h"

namespace pavo::test {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class Benchmarks : public ::testing::Test {
 protected:
  Words call(const Words& more) const {
    Words words{"bench", recording.path(), "--no-people", "--seconds", "0.1", "--frames", "6"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  json measured(const Words& more) const {
    Words words = call({"--json", file});
    words.insert(words.end(), more.begin(), more.end());
    const Called called = pavo(words);
    EXPECT_EQ(called.status, 0) << called.error;
    EXPECT_THAT(called.out, AllOf(HasSubstr("capacity: "), HasSubstr("end to end"), HasSubstr("odometry service")));
    return json::parse(bytes_of(file));
  }
  void expect_refused(const Words& more, int status, const std::string& told) const {
    const Called called = pavo(call(more));
    const std::string words = ::testing::PrintToString(more);
    EXPECT_EQ(called.status, status) << words;
    EXPECT_THAT(called.error, AllOf(IsOneLine(), StartsWith("pavo: "), HasSubstr(told))) << words;
    EXPECT_EQ(called.out, "") << words;
  }
  Recording recording;
  std::string file = recording.path() + "/bench.json";
};

void expect_in_order(const json& quantiles) {
  ASSERT_EQ(quantiles.size(), 5u);
  double before = 0;
  for (const char* q : {"p50", "p90", "p99", "p999", "max"}) {
    const double value = quantiles.at(q).get<double>();
    EXPECT_GE(value, before) << quantiles.dump();
    before = value;
  }
}

void expect_complete_run(const json& run, double load_percent) {
  EXPECT_NEAR(run.at("load_percent").get<double>(), load_percent, 1e-9);
  EXPECT_GT(run.at("offered_fps").get<double>(), 0);
  EXPECT_GT(run.at("done_fps").get<double>(), 0);
  EXPECT_LE(run.at("done_fps").get<double>(), run.at("offered_fps").get<double>() * (1 + 1e-9));
  EXPECT_GE(run.at("dropped").get<int>(), 0);
  expect_in_order(run.at("end_to_end_ms"));
  expect_in_order(run.at("age_ms"));
  EXPECT_GT(run.at("end_to_end_ms").at("p50").get<double>(), 0);
  for (const char* stage : {"decode", "features", "odometry"})
    for (const char* what : {"wait_ms", "service_ms", "cpu_ms"}) expect_in_order(run.at("stages").at(stage).at(what));
}

TEST_F(Benchmarks, HaveARunForEachLoad) {
  const json bench = measured({"--load", "50", "150", "--repeat", "2"});
  EXPECT_GT(bench.at("capacity_fps").get<double>(), 0);
  for (const char* what : {"cpu", "governor", "kernel", "simd"})
    EXPECT_NE(bench.at("machine").at(what).get<std::string>(), "") << what;
  EXPECT_GE(bench.at("machine").at("cores").get<int>(), 1);
  ASSERT_EQ(bench.at("runs").size(), 2u);
  expect_complete_run(bench.at("runs")[0], 50);
  expect_complete_run(bench.at("runs")[1], 150);
  ASSERT_EQ(bench.at("repeats").size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) expect_complete_run(bench.at("repeats")[i], i < 2 ? 50 : 150);
  EXPECT_NEAR(bench.at("runs")[1].at("offered_fps").get<double>(), 1.5 * bench.at("capacity_fps").get<double>(), 1e-6);
}

TEST_F(Benchmarks, HaveFourLoadsWhereNoneAreNamed) {
  const json bench = measured({"--repeat", "1"});
  ASSERT_EQ(bench.at("runs").size(), 4u);
  const double loads[] = {50, 80, 100, 120};
  for (std::size_t i = 0; i < 4; ++i) expect_complete_run(bench.at("runs")[i], loads[i]);
}

TEST_F(Benchmarks, AtARateOfferJustThat) {
  const json bench = measured({"--rate", "80", "--repeat", "1"});
  ASSERT_EQ(bench.at("runs").size(), 1u);
  EXPECT_EQ(bench.at("runs")[0].at("offered_fps").get<double>(), 80);
  EXPECT_NEAR(bench.at("runs")[0].at("load_percent").get<double>(), 8000 / bench.at("capacity_fps").get<double>(),
              1e-6);
}

TEST_F(Benchmarks, OfEveryFrameDropNone) {
  const json bench = measured({"--every-frame", "--load", "200", "--repeat", "1"});
  EXPECT_EQ(bench.at("runs")[0].at("dropped").get<int>(), 0);
  EXPECT_EQ(bench.at("mode").get<std::string>(), "every-frame");
}

TEST_F(Benchmarks, DrawTheirFigures) {
  const std::string svg = recording.path() + "/bench.svg";
  const Called called = pavo(call({"--load", "50", "90", "--repeat", "1", "--plot", svg}));
  EXPECT_EQ(called.status, 0) << called.error;
  EXPECT_THAT(bytes_of(svg), AllOf(StartsWith("<"), HasSubstr("percentile"), HasSubstr("50 %: "), HasSubstr("90 %: "),
                                   EndsWith("</svg>\n")));
}

TEST_F(Benchmarks, AreComparedWithEarlierOnes) {
  json bench = measured({"--load", "50", "--repeat", "2"});
  const auto against = [&](const json& old) {
    recording.write("old.json", old.dump());
    const Called called = pavo(call({"--load", "50", "--repeat", "2", "--against", recording.file("old.json")}));
    EXPECT_EQ(called.status, 0) << called.error;
    return called.out;
  };
  EXPECT_THAT(against(bench), AllOf(HasSubstr("old.json (1 loads in both):"), HasSubstr(" within noise, ")));

  // A machine that was a million times slower is beyond noise, and told as another machine.
  bench["capacity_fps"] = bench["capacity_fps"].get<double>() * 1e-6;
  for (json& fps : bench["capacities_fps"]) fps = fps.get<double>() * 1e-6;
  bench["machine"]["cpu"] = "an abacus";
  const std::string told = against(bench);
  EXPECT_THAT(told, AllOf(HasSubstr("  capacity "), HasSubstr("better"),
                          HasSubstr("not measured alike: machine/cpu was \"an abacus\"")));
}

TEST_F(Benchmarks, RefuseWrongCalls) {
  expect_refused({"--rate", "0"}, 2, "--rate must be from 0.01 to 100000, not 0");
  expect_refused({"--rate", "nan"}, 2, "--rate must be from");
  expect_refused({"--rate", "fast"}, 2, "--rate");
  expect_refused({"--load", "0"}, 2, "--load must be from 0.1 to 1000, not 0");
  expect_refused({"--load", "50", "-80"}, 2, "--load must be from 0.1 to 1000, not -80");
  expect_refused({"--load", "50", "--rate", "10"}, 2, "excludes");
  expect_refused({"--repeat", "0"}, 2, "--repeat must be from 1 to 1000, not 0");
  expect_refused({"--workers", "many"}, 2, "--workers must be a whole number");
  expect_refused({"--simd", "MMX"}, 2, "no target 'MMX'");
  expect_refused({"--jsno", "x"}, 2, "no such option: --jsno; did you mean --json?");
  expect_refused({"--json", recording.path()}, 2, "this is a folder, expected a file");
  expect_refused({"--json", recording.path() + "/no/where.json"}, 1, "there is no folder");
}

TEST_F(Benchmarks, RefuseWhatIsNoEarlierResult) {
  expect_refused({"--against", recording.file("none.json")}, 1, "none.json: cannot be read: No such file");
  for (const char* text : {"", "{", "[]", "{}", "{\"capacity_fps\": 1}", "{\"capacity_fps\": \"x\", \"runs\": []}",
                           "{\"capacity_fps\": 1, \"runs\": [{}]}", "{\"capacity_fps\": 1, \"runs\": [7]}",
                           "{\"capacity_fps\": 1, \"runs\": [], \"capacities_fps\": [\"x\"]}"}) {
    recording.write("old.json", text);
    expect_refused({"--against", recording.file("old.json")}, 1, "old.json: this is no ");
  }
}

TEST_F(Benchmarks, RefuseFramesThatCannotBeUsed) {
  std::filesystem::resize_file(recording.image(2), 100);
  const Called called = pavo(call({"--repeat", "1"}));
  EXPECT_EQ(called.status, 1);
  EXPECT_THAT(called.error, AllOf(IsOneLine(), HasSubstr("a frame failed"), HasSubstr("decode")));
  EXPECT_EQ(pavo({"bench", recording.file("none")}).status, 1);
  EXPECT_EQ(pavo({"bench", ""}).status, 2);
}

}  // namespace
}  // namespace pavo::test
