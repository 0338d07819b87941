// --trace and --metrics: files that can be read, agree with the report, and change nothing; a source that hangs is
// named.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "tests/command/command.h"

namespace pavo::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

TEST(TraceAndMetrics, AgreeWithTheReportAndChangeNothing) {
  const Recording recording;
  const std::string trace = recording.out("trace.json"), metrics = recording.out("metrics.jsonl");
  ASSERT_EQ(pavo(recording.run({"--trace", trace, "--metrics", metrics, "--workers", "2"})).status, 0);
  const json report = report_of(recording.out());

  const json events = json::parse(bytes_of(trace)).at("traceEvents");
  std::set<int> delivered;
  for (const json& e : events)
    if (e.at("ph") == "X" && e.at("name") == "delivery") delivered.insert(e.at("args").at("frame").get<int>());
  EXPECT_EQ(delivered.size(), kFrames);

  const std::vector<std::string> lines = lines_of(metrics);
  ASSERT_GE(lines.size(), 1u);
  double t = -1;
  for (const std::string& line : lines) {
    const json m = json::parse(line);
    EXPECT_GT(m.at("t_s").get<double>(), t);
    t = m.at("t_s");
    const json& f = m.at("frames");
    EXPECT_EQ(f.at("in").get<int>(), f.at("done").get<int>() + f.at("failed").get<int>() + f.at("dropped").get<int>() +
                                         f.at("in_flight").get<int>());
    for (const char* name : {"end_to_end", "age", "jitter"})
      EXPECT_LE(m.at("latency_ms").at(name).at("p50").get<double>(),
                m.at("latency_ms").at(name).at("max").get<double>());
    EXPECT_LE(m.at("ring").at("in_flight").at("max").get<double>(), m.at("ring").at("slots").get<double>());
  }
  EXPECT_EQ(json::parse(lines.back()).at("frames"), report.at("frames"));

  ASSERT_EQ(pavo({"run", recording.path(), "--out", recording.out("plain"), "--no-people"}).status, 0);
  EXPECT_EQ(bytes_of(recording.out("plain") + "/trajectory.kitti"), bytes_of(recording.out() + "/trajectory.kitti"));
}

TEST(TraceAndMetrics, ThatCannotBeWrittenAreOneError) {
  const Recording recording;
  for (const char* option : {"--trace", "--metrics"}) {
    const Called call = pavo(recording.run({option, "/nowhere/at/all.json"}));
    EXPECT_EQ(call.status, 1);
    EXPECT_THAT(call.error, IsOneLine());
    EXPECT_THAT(call.error, HasSubstr("/nowhere/at/all.json"));
    EXPECT_EQ(pavo(recording.run({option, ""})).status, 2);
  }
}

}  // namespace
}  // namespace pavo::test
