// Affinity, pinning, SCHED_FIFO, locked memory; the fallback of a stage for frames that are late.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include <set>
#include <thread>

#include "tests/engine/numbers.h"

namespace pavo::test {
namespace {

using testing::HasSubstr;

std::string thread_name() {
  char name[16] = {};
  pthread_getname_np(pthread_self(), name, sizeof name);
  return name;
}

struct WhoAmI {
  std::mutex& mutex;
  std::set<std::string>& names;
  void operator()(const std::int64_t& in, std::int64_t& out) const {
    const std::lock_guard lock(mutex);
    names.insert(thread_name());
    out = in;
  }
};

TEST(Affinity, KeepsAStageToItsWorkers) {
  SteadyClock clock;
  PipelineOptions options = workers(4);
  options.affinity = {{"square", {1, 3}}, {"sum", {0}}, {"delivery", {2}}};
  Pipeline<Numbers> pipeline(options, clock);
  std::mutex mutex;
  std::set<std::string> square, twice, sum, delivery;
  pipeline.source(writes(&Numbers::input));
  pipeline.add("square", reads(&Numbers::input), writes(&Numbers::squared), WhoAmI{mutex, square}, parallel);
  pipeline.add("double", reads(&Numbers::squared), writes(&Numbers::doubled), WhoAmI{mutex, twice}, parallel);
  pipeline.add("sum", reads(&Numbers::doubled), writes(&Numbers::sum), WhoAmI{mutex, sum}, parallel);
  pipeline.deliver([&](const Numbers&, const FrameInfo&, const Outcome&) { delivery.insert(thread_name()); });
  Counting source(2000);
  pipeline.run(source);
  EXPECT_EQ(pipeline.counts().done, 2000u);
  EXPECT_THAT(square, testing::IsSubsetOf({"pavo-worker1", "pavo-worker3"}));
  EXPECT_THAT(sum, testing::ElementsAre("pavo-worker0"));
  EXPECT_THAT(delivery, testing::ElementsAre("pavo-worker2"));
}

TEST(Affinity, ThatMakesNoSenseIsRefused) {
  SteadyClock clock;
  for (const PipelineOptions::Affinity& a :
       {PipelineOptions::Affinity{"square", {2}}, {"square", {}}, {"square", {-1}}, {"nobody", {0}}}) {
    PipelineOptions options = workers(2);
    options.affinity = {a};
    Pipeline<Numbers> pipeline(options, clock);
    pipeline.source(writes(&Numbers::input));
    pipeline.add("square", reads(&Numbers::input), writes(&Numbers::sum), Square{}, parallel);
    try {
      pipeline.prepare();
      ADD_FAILURE() << a.stage;
    } catch (const std::invalid_argument& e) {
      EXPECT_THAT(e.what(), HasSubstr("affinity"));
    }
  }
}

std::vector<std::string> refusals(const PipelineOptions& options) {
  SteadyClock clock;
  Pipeline<Numbers> pipeline(options, clock);
  pipeline.source(writes(&Numbers::input));
  pipeline.add("square", reads(&Numbers::input), writes(&Numbers::sum), Square{}, parallel);
  Counting source(20);
  pipeline.run(source);
  EXPECT_EQ(pipeline.counts().done, 20u) << "the run goes on";
  return pipeline.runtime().refusals();
}

TEST(Pinning, ToACpuThatIsThereIsDoneAndElseRefusedInOneLine) {
  cpu_set_t set;
  ASSERT_EQ(sched_getaffinity(0, sizeof set, &set), 0);
  int there = 0;
  while (!CPU_ISSET(static_cast<std::size_t>(there), &set)) ++there;
  PipelineOptions options = workers(3);
  options.cpus = {there};
  EXPECT_TRUE(refusals(options).empty());
  options.cpus = {1000};
  const std::vector<std::string> lines = refusals(options);
  ASSERT_EQ(lines.size(), 1u) << "told once, not by every worker";
  EXPECT_THAT(lines[0], HasSubstr("not pinned to cpu 1000"));
  EXPECT_EQ(lines[0].find('\n'), std::string::npos);
}

TEST(RealTime, IsGrantedOrRefusedPolitelyAndTheCallerIsAsBefore) {
  PipelineOptions options = workers(2);
  options.fifo_priority = 10;
  for (const std::string& line : refusals(options)) EXPECT_THAT(line, HasSubstr("SCHED_FIFO at priority 10"));
  EXPECT_EQ(sched_getscheduler(0), SCHED_OTHER);
}

TEST(Options, OfSchedulingOutOfRangeAreTold) {
  for (auto broken :
       {+[](PipelineOptions& o) { o.fifo_priority = 100; }, +[](PipelineOptions& o) { o.background_nice = 20; },
        +[](PipelineOptions& o) { o.cpus = {-1}; }, +[](PipelineOptions& o) { o.stage_limit_ns = -1; }}) {
    PipelineOptions options;
    broken(options);
    EXPECT_NE(options.invalid(), "");
  }
}

// --- the fallback

struct ScanOrNot {
  void operator()(const std::int64_t& in, std::int64_t& out) const { out = in; }
  void late(const std::int64_t&, std::int64_t& out) const { out = -1; }
};

// Frames that are as old as the test says when they come.
class Aged : public Source<Numbers> {
 public:
  Aged(const Clock& clock, std::vector<std::int64_t> ages_ns) : clock_(clock), ages_ns_(std::move(ages_ns)) {}
  bool read(FrameInfo& info, Numbers& frame) override {
    if (next_ == ages_ns_.size()) return false;
    info.t_arrival_ns = clock_.now_ns();
    info.t_sensor_ns = clock_.now_ns() - ages_ns_[next_];
    frame.input = static_cast<std::int64_t>(next_++);
    return true;
  }
  std::optional<std::int64_t> next_arrival_ns() override { return 0; }
  bool holds_newest() const override { return true; }

 private:
  const Clock& clock_;
  std::vector<std::int64_t> ages_ns_;
  std::size_t next_ = 0;
};

std::vector<std::int64_t> scanned(Admission admission, std::int64_t budget_ns, std::uint64_t& late) {
  ManualClock clock(1'000'000'000);
  PipelineOptions options = workers(2);
  options.admission = admission;
  options.latency_budget_ns = budget_ns;
  Pipeline<Numbers> pipeline(options, clock);
  std::vector<std::int64_t> out;
  pipeline.source(writes(&Numbers::input));
  pipeline.add("scan", reads(&Numbers::input), writes(&Numbers::sum), ScanOrNot{}, parallel);
  pipeline.deliver([&](const Numbers& frame, const FrameInfo&, const Outcome& outcome) {
    EXPECT_FALSE(outcome.failed);
    out.push_back(frame.sum);
  });
  Aged source(clock, {0, 50, 51, 49, 1000});
  pipeline.run(source);
  late = pipeline.runtime().stage_metrics(1).late;
  return out;
}

TEST(Fallback, IsUsedLiveForFramesOverTheirBudgetAndCounted) {
  std::uint64_t late = 0;
  EXPECT_THAT(scanned(Admission::live, 50, late), testing::ElementsAre(0, 1, -1, 3, -1));
  EXPECT_EQ(late, 2u);
  EXPECT_THAT(scanned(Admission::live, 0, late), testing::ElementsAre(0, 1, 2, 3, 4));
  EXPECT_EQ(late, 0u);
  EXPECT_THAT(scanned(Admission::every_frame, 50, late), testing::ElementsAre(0, 1, 2, 3, 4));
  EXPECT_EQ(late, 0u) << "where every frame counts, the result is no matter of time";
}

}  // namespace
}  // namespace pavo::test
