// The trace is what the viewers of Chrome's Trace Event Format expect, and tells what happened.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/trace.h"
#include "tests/engine/numbers.h"
#include "tests/support/temporary.h"

namespace pavo::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

struct SquareOrThrow {
  void operator()(const std::int64_t& in, std::int64_t& out) const {
    if (in == 13) throw std::runtime_error("unlucky");
    out = in * in;
  }
};

json trace_of_a_run(const std::string& path, std::int64_t frames, int workers_count) {
  SteadyClock clock;
  Trace trace(path);
  PipelineOptions options = workers(workers_count);
  options.trace = &trace;
  Pipeline<Numbers> pipeline(options, clock);
  Sum sum;
  pipeline.source(writes(&Numbers::input));
  pipeline.add("square", reads(&Numbers::input), writes(&Numbers::squared), SquareOrThrow{}, parallel);
  pipeline.add("double", reads(&Numbers::input), writes(&Numbers::doubled), Double{}, parallel);
  pipeline.add("sum", reads(&Numbers::squared, &Numbers::doubled), writes(&Numbers::sum), std::ref(sum), in_order);
  Counting source(frames);
  pipeline.run(source);
  trace.finish();
  EXPECT_EQ(trace.lost(), 0u);
  std::ifstream file(path);
  return json::parse(file);
}

struct Slice {
  double begin, end;
  std::string name;
  std::int64_t frame;
};

// What the format demands of every event; the slices by row.
std::map<int, std::vector<Slice>> checked_slices(const json& events) {
  std::map<int, std::vector<Slice>> slices;
  for (const json& e : events) {
    const std::string ph = e.at("ph");
    EXPECT_EQ(e.at("pid").get<int>(), getpid());
    EXPECT_TRUE(e.at("tid").is_number_integer());
    EXPECT_FALSE(e.at("name").get<std::string>().empty());
    if (ph == "M") {
      EXPECT_TRUE(e.at("args").is_object());
      continue;
    }
    EXPECT_GT(e.at("ts").get<double>(), 0);
    if (ph == "X") {
      EXPECT_GE(e.at("dur").get<double>(), 0);
      slices[e.at("tid")].push_back(
          {e.at("ts"), e.at("ts").get<double>() + e.at("dur").get<double>(), e.at("name"), e.at("args").at("frame")});
    } else if (ph == "s" || ph == "t") {
      EXPECT_TRUE(e.at("id").is_number_integer());
      EXPECT_EQ(e.at("cat"), "frame");
    } else {
      EXPECT_TRUE(ph == "C" || ph == "i") << ph;
    }
  }
  return slices;
}

TEST(Trace, HoldsEverySliceOnceAndRowsDoNotOverlap) {
  const TemporaryFolder folder;
  constexpr std::int64_t kFrames = 60;
  const json trace = trace_of_a_run(folder.file("t.json"), kFrames, 3);
  auto rows = checked_slices(trace.at("traceEvents"));
  std::map<std::string, std::set<std::int64_t>> frames_of;
  for (auto& [row, slices] : rows) {
    std::sort(slices.begin(), slices.end(), [](const Slice& a, const Slice& b) { return a.begin < b.begin; });
    for (std::size_t i = 0; i < slices.size(); ++i) {
      EXPECT_TRUE(frames_of[slices[i].name].insert(slices[i].frame).second) << "twice";
      if (i > 0) {
        EXPECT_LE(slices[i - 1].end, slices[i].begin + 0.002) << "row " << row;
      }
    }
  }
  for (const char* stage : {"source", "square", "double", "sum", "delivery"})
    EXPECT_EQ(frames_of[stage].size(), kFrames) << stage;
  EXPECT_EQ(trace.at("otherData").at("lost_events"), 0);
}

TEST(Trace, ArrowsFollowEachFrameFromTheSourceToTheDelivery) {
  const TemporaryFolder folder;
  const json events = trace_of_a_run(folder.file("t.json"), 40, 2).at("traceEvents");
  const auto rows = checked_slices(events);
  std::map<std::int64_t, std::map<std::string, int>> arrows;
  for (const json& e : events) {
    const std::string ph = e.at("ph");
    if (ph != "s" && ph != "t") continue;
    ++arrows[e.at("id")][ph];
    const double at = e.at("ts");
    const auto& slices = rows.at(e.at("tid"));
    EXPECT_TRUE(std::any_of(slices.begin(), slices.end(), [&](const Slice& s) {
      return s.begin <= at && at <= s.end && s.frame == e.at("id").get<std::int64_t>();
    })) << "an arrow binds to a slice of its own frame";
  }
  ASSERT_EQ(arrows.size(), 40u);
  for (auto& [frame, count] : arrows) {
    EXPECT_EQ(count["s"], 1);
    EXPECT_EQ(count["t"], 4) << "square, double, sum, delivery";
  }
}

struct Mapped {
  std::int64_t input = 0, sum = 0;
  Delayed<std::int64_t> map;
};

class CountingMapped : public Source<Mapped> {
 public:
  explicit CountingMapped(std::int64_t count) : count_(count) {}
  bool read(FrameInfo& info, Mapped& frame) override {
    frame.input = info.source_index = next_;
    return next_++ < count_;
  }
  std::optional<std::int64_t> next_arrival_ns() override { return 0; }

 private:
  std::int64_t count_, next_ = 0;
};

// Every second number goes on to the map, behind its delivery.
struct EverySecond {
  struct Work {
    std::int64_t number = 0;
  };
  bool take(const FrameInfo& info, const std::int64_t& in, Work& work) const {
    work.number = in;
    return info.sequence % 2 == 0;
  }
  bool operator()(const FrameInfo&, Work& work, std::int64_t& out) {
    out = work.number;
    return true;
  }
};

struct AddWhatFlowedBack {
  void operator()(const std::int64_t& in, const std::int64_t* back, std::int64_t& out) {
    out = in + (back ? *back : 0);
  }
  void missed(const std::int64_t*, std::int64_t&) {}
};

TEST(Trace, ArrowsGoOnToWhatIsDoneInTheBackground) {
  const TemporaryFolder folder;
  constexpr std::int64_t kFrames = 40;
  SteadyClock clock;
  Trace trace(folder.file("t.json"));
  PipelineOptions options = workers(2);
  options.trace = &trace;
  Pipeline<Mapped> pipeline(options, clock);
  pipeline.source(writes(&Mapped::input));
  pipeline.add("add", reads(&Mapped::input, delayed<2>(&Mapped::map)), writes(&Mapped::sum), AddWhatFlowedBack{},
               in_order);
  pipeline.add("map", reads(&Mapped::sum), writes(&Mapped::map), EverySecond{}, background);
  CountingMapped source(kFrames);
  pipeline.run(source);
  trace.finish();
  const json events = json::parse(bytes_of(folder.file("t.json"))).at("traceEvents");
  const auto rows = checked_slices(events);
  std::map<std::string, std::set<std::int64_t>> reached;  // which frames' arrows, by stage
  for (const json& e : events) {
    if (e.at("ph") != "s" && e.at("ph") != "t") continue;
    for (const Slice& s : rows.at(e.at("tid")))
      if (s.begin <= e.at("ts") && e.at("ts") <= s.end && s.frame == e.at("id")) reached[s.name].insert(s.frame);
  }
  EXPECT_EQ(reached["delivery"].size(), kFrames);
  EXPECT_EQ(reached["map"].size(), kFrames / 2);
}

TEST(Trace, NamesRowsAndOutcomes) {
  const TemporaryFolder folder;
  const json events = trace_of_a_run(folder.file("t.json"), 20, 2).at("traceEvents");
  std::set<std::string> rows, outcomes;
  for (const json& e : events) {
    if (e.at("name") == "thread_name") rows.insert(e.at("args").at("name"));
    if (e.at("ph") == "X" && e.at("args").at("frame") == 13)
      outcomes.insert(e.at("name").get<std::string>() + " " + e.at("args").at("outcome").get<std::string>());
  }
  EXPECT_THAT(rows, testing::IsSupersetOf({"source", "worker 0", "worker 1"}));
  EXPECT_THAT(outcomes, testing::UnorderedElementsAre("source ok", "square failed", "double ok", "sum missed",
                                                      "delivery failed"));
}

TEST(Trace, OfNothingIsStillATrace) {
  const TemporaryFolder folder;
  { const Trace never_started(folder.file("t.json")); }
  std::ifstream file(folder.file("t.json"));
  EXPECT_TRUE(json::parse(file).at("traceEvents").empty());
  EXPECT_TRUE(checked_slices(trace_of_a_run(folder.file("u.json"), 0, 1).at("traceEvents")).empty());
}

TEST(Trace, SaysWhatItCannotWrite) {
  try {
    Trace("/nowhere/at/all.json");
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), HasSubstr("/nowhere/at/all.json: cannot be written: No such file"));
  }
  Trace full("/dev/full");
  full.start({"source"}, {"source", "delivery"}, {});
  EXPECT_THROW(full.finish(), std::runtime_error);
}

TEST(Trace, LosesRatherThanWaits) {
  EventRing<int> ring(8);
  for (int i = 0; i < 20; ++i) ring.put(i);
  EXPECT_EQ(ring.lost(), 12u);
  std::vector<int> seen;
  ring.drain([&](int i) { seen.push_back(i); });
  EXPECT_THAT(seen, testing::ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
  ring.put(20);
  ring.drain([&](int i) { seen.push_back(i); });
  EXPECT_EQ(seen.back(), 20);
}

}  // namespace
}  // namespace pavo::test
