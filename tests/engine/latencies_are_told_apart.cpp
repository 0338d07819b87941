#include <gtest/gtest.h>

#include "tests/engine/numbers.h"

namespace pavo::test {
namespace {

class AtOnce : public Source<Numbers> {
 public:
  AtOnce(ManualClock& clock, int count) : clock_(clock), count_(count) {}
  bool read(FrameInfo& info, Numbers&) override {
    info.t_arrival_ns = clock_.now_ns();
    info.t_sensor_ns = info.t_arrival_ns - 5 * kMs;
    return count_-- > 0;
  }
  std::optional<std::int64_t> next_arrival_ns() override { return 0; }

 private:
  ManualClock& clock_;
  int count_;
};

TEST(Latency, OfAStageIsSplitIntoWaitAndServiceAndAgeCountsFromTheSensor) {
  ManualClock clock(1000 * kMs);
  PipelineOptions options = workers(1);
  options.slots = 1;  // one frame at a time, so that nothing waits
  Pipeline<Numbers> pipeline(options, clock);
  pipeline.source(writes(&Numbers::input));
  pipeline.add("first", reads(&Numbers::input), writes(&Numbers::squared), Takes{clock, 2 * kMs}, in_order);
  pipeline.add("second", reads(&Numbers::squared), writes(&Numbers::sum), Takes{clock, 3 * kMs}, in_order);
  AtOnce source(clock, 100);
  pipeline.run(source);

  const Runtime& runtime = pipeline.runtime();
  EXPECT_NEAR(runtime.stage_metrics(1).service.quantiles_ms().p50, 2, 0.02);
  EXPECT_NEAR(runtime.stage_metrics(2).service.quantiles_ms().p999, 3, 0.03);
  EXPECT_EQ(runtime.stage_metrics(1).wait.quantiles_ms().max, 0);
  EXPECT_NEAR(runtime.run_metrics().end_to_end.quantiles_ms().p50, 5, 0.05);
  EXPECT_NEAR(runtime.run_metrics().age.quantiles_ms().p50, 10, 0.1);
  EXPECT_EQ(runtime.stage_metrics(1).service.count(), 100u);
  EXPECT_EQ(runtime.stage_metrics(1).cpu.count(), 7u) << "one frame in 16";
}

TEST(Latency, OfAFrameThatWaitedItsTurnIsWait) {
  ManualClock clock(1000 * kMs);
  PipelineOptions options = workers(1);
  options.slots = 2;
  Pipeline<Numbers> pipeline(options, clock);
  pipeline.source(writes(&Numbers::input));
  pipeline.add("slow", reads(&Numbers::input), writes(&Numbers::sum), Takes{clock, 4 * kMs}, in_order);
  pipeline.start();
  pipeline.admit([](FrameInfo&, Numbers&) {});
  pipeline.admit([](FrameInfo&, Numbers&) {});
  pipeline.finish();
  const StageMetrics& slow = pipeline.runtime().stage_metrics(1);
  EXPECT_LE(slow.wait.quantiles_ms().max, 4.001);
  EXPECT_NEAR(slow.service.quantiles_ms().max, 4, 0.04);
}

}  // namespace
}  // namespace pavo::test
