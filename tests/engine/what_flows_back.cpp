// Delayed edges: exact where every frame counts, the newest where it is live.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <semaphore>
#include <thread>

#include "tests/engine/numbers.h"

namespace pavo::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

struct Looped {
  std::int64_t input = 0;
  std::int64_t prepared = 0;
  std::int64_t estimate = 0;
  Delayed<std::int64_t> correction;
};

class CountingLooped : public Source<Looped> {
 public:
  CountingLooped(std::int64_t count, std::vector<std::int64_t> unreadable)
      : count_(count), unreadable_(std::move(unreadable)) {}
  bool read(FrameInfo& info, Looped& frame) override {
    if (next_ == count_) return false;
    frame.input = info.source_index = next_++;
    if (std::find(unreadable_.begin(), unreadable_.end(), frame.input) != unreadable_.end())
      throw std::runtime_error("unreadable");
    return true;
  }
  std::optional<std::int64_t> next_arrival_ns() override { return 0; }

 private:
  std::int64_t count_;
  std::vector<std::int64_t> unreadable_;
  std::int64_t next_ = 0;
};

// Some nanoseconds to some hundred microseconds, another time on every run.
void dawdle() {
  thread_local std::minstd_rand random(std::random_device{}());
  const auto r = random();
  if (r % 16 == 0) std::this_thread::sleep_for(std::chrono::microseconds(r % 300));
}

// In order: every estimate depends on all before it, and on all that flowed back.
struct Estimate {
  std::int64_t last = 1;
  std::vector<std::int64_t> given;  ///< -1 for nothing

  void operator()(const std::int64_t& in, const std::int64_t* correction, std::int64_t& out) {
    out = last = (last * 31 + in + with(correction)) % 1'000'003;
  }
  void missed(const std::int64_t* correction, std::int64_t& out) { out = last = (last + with(correction)) % 1'000'003; }

 private:
  std::int64_t with(const std::int64_t* correction) {
    dawdle();
    given.push_back(correction ? *correction : -1);
    return correction ? *correction * 17 : 5;
  }
};

// Takes every third frame; makes nothing of some, and fails at others.
struct Refine {
  struct Work {
    std::int64_t frame = 0, estimate = 0;
  };
  std::int64_t state = 3;
  bool slow = true;

  bool take(const FrameInfo& info, const std::int64_t& estimate, Work& work) const {
    if (info.sequence % 50 == 48) throw std::runtime_error("cannot be taken");
    work = {static_cast<std::int64_t>(info.sequence), estimate};
    return info.sequence % 3 == 0;
  }
  bool operator()(const FrameInfo& info, Work& work, std::int64_t& correction) {
    if (slow) dawdle();
    EXPECT_EQ(static_cast<std::int64_t>(info.sequence), work.frame);
    state = (state * 7 + work.estimate) % 10'007;
    if (work.frame % 30 == 27) throw std::runtime_error("cannot be refined");
    correction = state;
    return work.frame % 21 != 0;
  }
};

// What must come out: the same in a plain loop.
template <int delay>
std::vector<std::int64_t> plain_loop(std::int64_t count, const std::vector<std::int64_t>& unreadable) {
  Estimate estimate;
  Refine refine{.slow = false};
  std::vector<std::optional<std::int64_t>> corrections;
  std::vector<std::int64_t> results;
  for (std::int64_t k = 0; k < count; ++k) {
    const auto* correction = k >= delay && corrections[static_cast<std::size_t>(k - delay)]
                                 ? &*corrections[static_cast<std::size_t>(k - delay)]
                                 : nullptr;
    const bool failed = std::find(unreadable.begin(), unreadable.end(), k) != unreadable.end();
    std::int64_t out = 0, made = 0;
    if (failed)
      estimate.missed(correction, out);
    else
      estimate(3 * k, correction, out);
    results.push_back(out);
    corrections.emplace_back();
    FrameInfo info;
    info.sequence = static_cast<std::uint64_t>(k);
    Refine::Work work;
    try {
      if (!failed && refine.take(info, out, work) && refine(info, work, made)) corrections.back() = made;
    } catch (const std::exception&) {
    }
  }
  return results;
}

template <int delay>
void declare(Pipeline<Looped>& pipeline, Estimate& estimate, Refine& refine) {
  pipeline.source(writes(&Looped::input));
  pipeline.add(
      "prepare", reads(&Looped::input), writes(&Looped::prepared),
      [](const std::int64_t& in, std::int64_t& out) {
        dawdle();
        out = 3 * in;
      },
      parallel);
  pipeline.add("estimate", reads(&Looped::prepared, delayed<delay>(&Looped::correction)), writes(&Looped::estimate),
               std::ref(estimate), in_order);
  pipeline.add("refine", reads(&Looped::estimate), writes(&Looped::correction), std::ref(refine), background);
}

template <int delay>
std::vector<std::int64_t> in_the_engine(const PipelineOptions& options, std::int64_t count,
                                        const std::vector<std::int64_t>& unreadable) {
  SteadyClock clock;
  Pipeline<Looped> pipeline(options, clock);
  Estimate estimate;
  Refine refine;
  declare<delay>(pipeline, estimate, refine);
  std::vector<std::int64_t> results;
  pipeline.deliver([&](const Looped& frame, const FrameInfo&, const Outcome&) { results.push_back(frame.estimate); });
  CountingLooped source(count, unreadable);
  pipeline.run(source);
  const StageMetrics& metrics = pipeline.runtime().stage_metrics(3);
  EXPECT_EQ(metrics.skipped, 0u) << "where every frame counts, none is left out";
  EXPECT_GT(metrics.failed, 0u);
  return results;
}

template <int delay>
void expect_exact() {
  constexpr std::int64_t kFrames = 300;
  const std::vector<std::int64_t> unreadable{0, 7, 9, 100, 101, 102, 103, 104, 299};
  const std::vector<std::int64_t> expected = plain_loop<delay>(kFrames, unreadable);
  for (const int n : {1, 2, 3, 4, 8})
    for (const int slots : {delay + 2, 0, 32}) {
      PipelineOptions options = workers(n);
      options.slots = slots;
      ASSERT_EQ(in_the_engine<delay>(options, kFrames, unreadable), expected)
          << n << " workers, " << slots << " slots, delay " << delay;
    }
}

TEST(Delayed, IsExactInReplayForAnyWorkersAndSlots) {
  expect_exact<1>();
  expect_exact<2>();
  expect_exact<5>();
}

TEST(Delayed, ABackgroundThatFailsAgainAndAgainEndsTheRun) {
  struct Hopeless : Refine {
    void operator()(Work&, std::int64_t&) { throw std::runtime_error("singular"); }
  };
  SteadyClock clock;
  PipelineOptions options = workers(2);
  options.failures_in_a_row = 4;
  Pipeline<Looped> pipeline(options, clock);
  Estimate estimate;
  std::int64_t delivered = 0;
  pipeline.source(writes(&Looped::input));
  pipeline.add("estimate", reads(&Looped::input, delayed<2>(&Looped::correction)), writes(&Looped::estimate),
               std::ref(estimate), in_order);
  pipeline.add("refine", reads(&Looped::estimate), writes(&Looped::correction), Hopeless{}, background);
  pipeline.deliver([&](const Looped&, const FrameInfo&, const Outcome& outcome) {
    EXPECT_FALSE(outcome.failed) << "it had been delivered already";
    ++delivered;
  });
  CountingLooped source(100'000, {});
  std::string error;
  try {
    pipeline.run(source);
  } catch (const RunError& e) {
    error = e.what();
  }
  EXPECT_EQ(error, "4 frames failed in a row in refine: singular");
  EXPECT_EQ(pipeline.counts().done, static_cast<std::uint64_t>(delivered));
}

// Waits for leave before each frame.
struct Hesitant {
  struct Work {
    std::int64_t number = 0;
  };
  std::counting_semaphore<1000>& leave;
  bool take(const std::int64_t& estimate, Work& work) const {
    work.number = estimate;
    return true;
  }
  void operator()(Work& work, std::int64_t& correction) {
    leave.acquire();
    correction = work.number;
  }
};

struct Copies {
  std::vector<std::int64_t> given;
  void operator()(const std::int64_t& in, const std::int64_t* correction, std::int64_t& out) {
    given.push_back(correction ? *correction : -1);
    out = in;
  }
  void missed(const std::int64_t*, std::int64_t&) {}
};

TEST(Delayed, LiveTheNewestIsTakenOnceAndNobodyWaits) {
  SteadyClock clock;
  PipelineOptions options = workers(2);
  options.admission = Admission::live;
  Pipeline<Looped> pipeline(options, clock);
  std::counting_semaphore<1000> leave{0};
  Copies copies;
  pipeline.source(writes(&Looped::input));
  pipeline.add("copy", reads(&Looped::input, delayed<1>(&Looped::correction)), writes(&Looped::estimate),
               std::ref(copies), in_order);
  pipeline.add("refine", reads(&Looped::estimate), writes(&Looped::correction), Hesitant{leave}, background);
  pipeline.start();
  const auto push = [&](std::int64_t number) {
    ASSERT_TRUE(pipeline.admit([&](FrameInfo&, Looped& frame) { frame.input = number; }));
    while (pipeline.counts().in_flight > 0) std::this_thread::yield();
  };
  const StageMetrics& refine = pipeline.runtime().stage_metrics(2);
  const auto until = [](auto there) {
    while (!there()) std::this_thread::yield();
  };

  for (std::int64_t k = 0; k < 10; ++k) push(k);  // all come out, though frame 0 is still worked on in the background
  EXPECT_EQ(pipeline.counts().done, 10u);
  until([&] { return refine.skipped == 7; });  // there is Work for three
  leave.release(3);
  until([&] { return refine.service.count() == 3; });
  push(10);
  push(11);
  leave.release(1000 - 3);
  until([&] { return refine.service.count() == 5; });
  push(12);
  pipeline.finish();
  EXPECT_THAT(copies.given, ElementsAre(-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, 2, -1, 11));
  EXPECT_EQ(refine.service.count(), 6u) << "what was taken over is worked on to the end";
}

TEST(Delayed, LiveReadersNeverSeeAValueThatIsBeingWritten) {
  struct Blocks {
    std::int64_t input = 0, estimate = 0, second = 0;
    Delayed<std::vector<std::int64_t>> block;
  };
  struct Fill {
    struct Work {
      std::int64_t number = 0;
    };
    bool take(const std::int64_t& n, const std::int64_t&, Work& work) const {
      work.number = n;
      return true;
    }
    void operator()(Work& work, std::vector<std::int64_t>& block) { block.assign(100, work.number); }
  };
  struct Check {
    std::int64_t last = -1;
    void operator()(const std::int64_t& in, const std::vector<std::int64_t>* block, std::int64_t& out) {
      out = in;
      if (!block) return;
      for (const std::int64_t v : *block) ASSERT_EQ(v, block->front());
      EXPECT_GT(block->front(), last) << "newer ones only";
      last = block->front();
    }
    void missed(const std::vector<std::int64_t>*, std::int64_t&) {}
  };
  SteadyClock clock;
  PipelineOptions options = workers(3);
  options.admission = Admission::live;
  options.live_credits = 4;
  Pipeline<Blocks> pipeline(options, clock);
  Check first, second;
  pipeline.source(writes(&Blocks::input));
  pipeline.add("first", reads(&Blocks::input, delayed<1>(&Blocks::block)), writes(&Blocks::estimate), std::ref(first),
               in_order);
  pipeline.add("second", reads(&Blocks::input, delayed<2>(&Blocks::block)), writes(&Blocks::second), std::ref(second),
               in_order);
  pipeline.add("fill", reads(&Blocks::estimate, &Blocks::second), writes(&Blocks::block), Fill{}, background);
  pipeline.start();
  const Histogram& filled = pipeline.runtime().stage_metrics(3).service;
  for (std::int64_t k = 0; pipeline.counts().done < 3000 || filled.count() < 300; ++k)
    pipeline.admit([&](FrameInfo&, Blocks& frame) { frame.input = k; });
  pipeline.finish();
  EXPECT_GT(first.last, 0);
  EXPECT_GT(second.last, 0);
}

// --- what the check of the graph says

struct Nop {
  void operator()(const std::int64_t&, std::int64_t&) const {}
};
struct NopDelayed {
  void operator()(const std::int64_t&, const std::int64_t*, std::int64_t&) const {}
  void missed(const std::int64_t*, std::int64_t&) {}
};
struct NopBackground {
  struct Work {};
  bool take(const std::int64_t&, Work&) const { return false; }
  void operator()(Work&, std::int64_t&) {}
};

template <class Declare>
std::string complaint_of_loop(Declare declare) {
  SteadyClock clock;
  Pipeline<Looped> pipeline(workers(1), clock);
  pipeline.source(writes(&Looped::input));
  declare(pipeline);
  try {
    pipeline.prepare();
  } catch (const GraphError& e) {
    return e.what();
  }
  return "";
}

TEST(Delayed, ThatNobodyWritesOrThatDoesNotLeadBackIsRefused) {
  EXPECT_THAT(complaint_of_loop([](auto& p) {
                p.add("estimate", reads(&Looped::input, delayed<1>(&Looped::correction)), writes(&Looped::estimate),
                      NopDelayed{}, in_order);
              }),
              AllOf(HasSubstr("'estimate'"), HasSubstr("no stage and no source writes")));
  EXPECT_THAT(complaint_of_loop([](auto& p) {
                p.add("aside", reads(&Looped::input, delayed<1>(&Looped::correction)), writes(&Looped::estimate),
                      NopDelayed{}, in_order);
                p.add("map", reads(&Looped::input), writes(&Looped::correction), NopBackground{}, background);
              }),
              AllOf(HasSubstr("'aside'"), HasSubstr("'map'"), HasSubstr("leads back only")));
}

TEST(Delayed, OfAParallelStageIsRefused) {
  EXPECT_THAT(complaint_of_loop([](auto& p) {
                p.add("estimate", reads(&Looped::input, delayed<1>(&Looped::correction)), writes(&Looped::estimate),
                      NopDelayed{}, parallel);
                p.add("map", reads(&Looped::estimate), writes(&Looped::correction), NopBackground{}, background);
              }),
              AllOf(HasSubstr("'estimate'"), HasSubstr("only an in-order stage")));
}

TEST(Delayed, GraphChecksWhatTypesCannotSay) {
  const Part a{0, "a"}, b{8, "b"}, c{16, "c"};
  const auto told = [&](std::vector<StageDeclaration> stages) -> std::string {
    try {
      derive_graph({a}, stages);
    } catch (const GraphError& e) {
      return e.what();
    }
    return "";
  };
  const StageDeclaration map{.name = "map", .kind = StageKind::background, .reads = {b}, .writes = {c}};
  EXPECT_THAT(told({{.name = "plain", .reads = {a}, .writes = {b}}, map, {.name = "hasty", .reads = {c}}}),
              AllOf(HasSubstr("'hasty'"), HasSubstr("delayed<>()")));
  EXPECT_THAT(told({{.name = "first", .reads = {a}, .writes = {b}},
                    {.name = "loop", .kind = StageKind::in_order, .reads = {a}, .delayed = {{b, 1}}}}),
              HasSubstr("is not a background stage"));
  EXPECT_THAT(
      told({{.name = "loop", .kind = StageKind::in_order, .reads = {a}, .delayed = {{c, 0}}, .writes = {b}}, map}),
      HasSubstr("expected at least 1"));
  const Graph graph = derive_graph(
      {a}, {{.name = "loop", .kind = StageKind::in_order, .reads = {a}, .delayed = {{c, 4}}, .writes = {b}}, map});
  EXPECT_EQ(graph.buffers, 6);
  EXPECT_EQ(graph.minimum_slots, 6u);
  EXPECT_EQ(graph.nodes[graph.delivery()].producers, (std::vector<std::size_t>{0, 1})) << "the map is not waited for";
}

}  // namespace
}  // namespace pavo::test
