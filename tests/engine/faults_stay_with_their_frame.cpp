#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/engine/numbers.h"

namespace pavo::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

struct SquareButNot {
  std::int64_t multiple_of;
  void operator()(const std::int64_t& in, std::int64_t& out) const {
    if (in % multiple_of == 3) throw std::runtime_error("cannot square " + std::to_string(in));
    out = in * in;
  }
};

struct RunRecord {
  std::vector<Delivered> delivered;
  Sum sum;
  Counts counts;
  std::string error;
};

template <class SquareStage, class DoubleStage>
RunRecord run(PipelineOptions options, SquareStage square, DoubleStage twice, Counting source) {
  SteadyClock clock;
  RunRecord r;
  Pipeline<Numbers> pipeline(options, clock);
  pipeline.source(writes(&Numbers::input));
  pipeline.add("square", reads(&Numbers::input), writes(&Numbers::squared), square, parallel);
  pipeline.add("double", reads(&Numbers::input), writes(&Numbers::doubled), twice, parallel);
  pipeline.add("sum", reads(&Numbers::squared, &Numbers::doubled), writes(&Numbers::sum), std::ref(r.sum), in_order);
  pipeline.deliver(collect(r.delivered));
  try {
    pipeline.run(source);
  } catch (const RunError& e) {
    r.error = e.what();
  }
  r.counts = pipeline.counts();
  return r;
}

TEST(Faults, AreDeliveredInTheirPlaceWithTheStagesNameAndMessage) {
  const RunRecord r = run(workers(3), SquareButNot{50}, Double{}, Counting(1000));
  ASSERT_EQ(r.delivered.size(), 1000u);
  std::int64_t expected = 0;
  for (std::int64_t i = 0; i < 1000; ++i) {
    const Delivered& d = r.delivered[i];
    ASSERT_EQ(d.source_index, i);
    EXPECT_EQ(d.failed, i % 50 == 3);
    if (d.failed) {
      EXPECT_EQ(d.stage, "square");
      EXPECT_EQ(d.message, "cannot square " + std::to_string(i));
    } else {
      expected += i * i + 2 * i;
    }
    EXPECT_EQ(d.sum, expected) << "the in-order stage writes its fallback for a missed frame";
  }
  EXPECT_EQ(r.counts.failed, 20u);
  EXPECT_EQ(r.counts.done, 980u);
}

TEST(Faults, LeaveNoHoleInWhatAnInOrderStageSees) {
  const RunRecord r = run(workers(4), SquareButNot{7}, Double{}, Counting(500, {0, 100, 499}));
  std::vector<std::uint64_t> all = r.sum.seen;
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end()));
  EXPECT_TRUE(std::is_sorted(r.sum.missing.begin(), r.sum.missing.end()));
  all.insert(all.end(), r.sum.missing.begin(), r.sum.missing.end());
  std::sort(all.begin(), all.end());
  ASSERT_EQ(all.size(), 500u);
  for (std::uint64_t i = 0; i < 500; ++i) EXPECT_EQ(all[i], i);
}

TEST(Faults, OfTheSourceFailTheFrameAndNameIt) {
  const RunRecord r = run(workers(2), Square{}, Double{}, Counting(20, {7}));
  ASSERT_EQ(r.delivered.size(), 20u);
  EXPECT_TRUE(r.delivered[7].failed);
  EXPECT_EQ(r.delivered[7].stage, "source");
  EXPECT_EQ(r.delivered[7].message, "number 7 is unreadable");
  EXPECT_EQ(r.counts.failed, 1u);
}

TEST(Faults, OfTwoStagesNameTheFirstDeclared) {
  struct Fail {
    void operator()(const std::int64_t& in, std::int64_t& out) const {
      if (in == 2) throw std::runtime_error("so did I");
      out = in;
    }
  };
  for (int i = 0; i < 50; ++i) {
    const RunRecord r = run(workers(2), Fail{}, Fail{}, Counting(4));
    EXPECT_EQ(r.delivered[2].stage, "square");
  }
}

TEST(Faults, ThatAreNoExceptionAreToldToo) {
  struct ThrowsInt {
    void operator()(const std::int64_t& in, std::int64_t& out) const {
      if (in == 1) throw 42;
      out = in;
    }
  };
  const RunRecord r = run(workers(2), ThrowsInt{}, Double{}, Counting(3));
  EXPECT_THAT(r.delivered[1].message, HasSubstr("no std::exception"));
}

TEST(Faults, TooManyInARowEndTheRunWithThatError) {
  PipelineOptions options = workers(2);
  options.failures_in_a_row = 5;
  const RunRecord r = run(options, SquareButNot{50}, Double{}, Counting(10000, {20, 21, 22, 23, 24}));
  EXPECT_EQ(r.error, "5 frames failed in a row, the last in source: number 24 is unreadable");
  EXPECT_LT(r.counts.in, 10000u);
  EXPECT_EQ(r.counts.in, r.counts.done + r.counts.failed + r.counts.dropped);
  EXPECT_EQ(r.counts.in_flight, 0u);
}

TEST(Faults, OfAnInOrderStageWriteItsFallback) {
  struct Fragile {
    int missed_calls = 0;
    void operator()(const std::int64_t& in, std::int64_t& out) {
      out = -1;
      if (in == 3) throw std::runtime_error("half written");
      out = in;
    }
    void missed(std::int64_t& out) {
      ++missed_calls;
      out = 1000;
    }
  };
  SteadyClock clock;
  Fragile fragile;
  Pipeline<Numbers> pipeline(workers(2), clock);
  std::vector<Delivered> delivered;
  pipeline.source(writes(&Numbers::input));
  pipeline.add("fragile", reads(&Numbers::input), writes(&Numbers::sum), std::ref(fragile), in_order);
  pipeline.deliver(collect(delivered));
  Counting source(6);
  pipeline.run(source);
  EXPECT_TRUE(delivered[3].failed);
  EXPECT_EQ(delivered[3].sum, 1000);
  EXPECT_EQ(delivered[4].sum, 4);
  EXPECT_EQ(fragile.missed_calls, 1);
}

TEST(Delivery, ThatThrowsEndsTheRunWithItsException) {
  SteadyClock clock;
  Pipeline<Numbers> pipeline(workers(2), clock);
  pipeline.source(writes(&Numbers::input));
  pipeline.add("square", reads(&Numbers::input), writes(&Numbers::sum), Square{}, parallel);
  int calls = 0;
  pipeline.deliver([&](const Numbers&, const FrameInfo& info, const Outcome&) {
    ++calls;
    if (info.sequence == 10) throw std::runtime_error("the disk is full");
  });
  Counting source(100000);
  EXPECT_THROW(
      {
        try {
          pipeline.run(source);
        } catch (const std::runtime_error& e) {
          EXPECT_STREQ(e.what(), "the disk is full");
          throw;
        }
      },
      std::runtime_error);
  EXPECT_EQ(calls, 11);
}

}  // namespace
}  // namespace pavo::test
