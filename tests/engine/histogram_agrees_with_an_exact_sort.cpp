#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <thread>

#include "engine/histogram.h"
#include "engine/histogram_interval.h"

namespace pavo::test {
namespace {

double exact(const std::vector<std::int64_t>& sorted, double q) {
  const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(sorted.size())));
  return static_cast<double>(sorted[std::max<std::size_t>(rank, 1) - 1]);
}

TEST(Histogram, QuantilesAreWithinOnePercentOfAnExactSort) {
  std::mt19937_64 random(1);
  for (const double spread : {0.1, 1.0, 4.0}) {
    std::lognormal_distribution<double> latency(13.0, spread);  // around half a millisecond
    Histogram histogram;
    std::vector<std::int64_t> values;
    for (int i = 0; i < 50000; ++i) {
      values.push_back(std::min<std::int64_t>(static_cast<std::int64_t>(latency(random)), (std::int64_t{1} << 42) - 1));
      histogram.record(values.back());
    }
    std::sort(values.begin(), values.end());
    for (const double q : {0.0, 0.01, 0.5, 0.9, 0.99, 0.999, 0.9999, 1.0})
      EXPECT_NEAR(histogram.quantile(q), exact(values, q), 0.01 * exact(values, q) + 0.5) << "q " << q;
    EXPECT_EQ(histogram.max_ns(), static_cast<std::uint64_t>(values.back()));
    EXPECT_EQ(histogram.count(), values.size());
  }
}

TEST(Histogram, IntervalsSeeWhatCameSinceTheLastLook) {
  std::mt19937_64 random(2);
  Histogram histogram;
  HistogramInterval interval(histogram);
  EXPECT_EQ(interval.look_ms().count, 0u);
  for (const double middle : {12.0, 16.0, 10.0}) {
    std::lognormal_distribution<double> latency(middle, 1);
    std::vector<std::int64_t> values;
    for (int i = 0; i < 2000; ++i) histogram.record(values.emplace_back(static_cast<std::int64_t>(latency(random))));
    std::sort(values.begin(), values.end());
    const Quantiles q = interval.look_ms();
    EXPECT_EQ(q.count, 2000u);
    for (const auto& [is, share] : {std::pair(q.p50, 0.5), {q.p90, 0.9}, {q.p99, 0.99}, {q.p999, 0.999}, {q.max, 1.0}})
      EXPECT_NEAR(is * 1e6, exact(values, share), 0.01 * exact(values, share) + 0.5);
  }
  EXPECT_EQ(interval.look_ms().max, 0);
}

TEST(Histogram, EveryPowerOfTwoAndItsNeighboursFallWhereTheyBelong) {
  for (int bit = 0; bit < 42; ++bit)
    for (const std::int64_t off : {-1, 0, 1}) {
      const std::int64_t value = std::max<std::int64_t>((std::int64_t{1} << bit) + off, 0);
      Histogram histogram;
      histogram.record(value);
      EXPECT_NEAR(histogram.quantile(0.5), static_cast<double>(value), 0.01 * static_cast<double>(value) + 0.5);
    }
}

TEST(Histogram, NegativeCountsAsZeroAndTheVeryLongKeepsItsMaximum) {
  Histogram histogram;
  EXPECT_EQ(histogram.quantile(0.5), 0);
  histogram.record(-5);
  EXPECT_EQ(histogram.quantile(0.5), 0);
  histogram.record(std::int64_t{1} << 50);
  EXPECT_EQ(histogram.quantile(1.0), std::ldexp(1.0, 50));
}

TEST(Histogram, LosesNoRecordWhenSeveralThreadsWrite) {
  Histogram histogram;
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t)
      threads.emplace_back([&, t] {
        for (int i = 0; i < 5000; ++i) histogram.record(t * 5000 + i);
      });
  }
  EXPECT_EQ(histogram.count(), 20000u);
  EXPECT_EQ(histogram.max_ns(), 19999u);
}

}  // namespace
}  // namespace pavo::test
