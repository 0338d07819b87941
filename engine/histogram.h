// Latencies without keeping samples: a log-linear histogram, after HdrHistogram (Tene).
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>

namespace pavo {

struct Quantiles {
  double p50 = 0, p90 = 0, p99 = 0, p999 = 0, max = 0;
  std::uint64_t count = 0;
};

/// Counts of non-negative nanoseconds, every octave divided into 128 equal buckets: the value that a quantile names is
/// at most 1/128 off (at most half of that below 2^42 ns = 73 minutes; longer ones are counted in the last bucket, and
/// max() is exact). record() may be called by any number of threads, is wait-free and never allocates; the readers may
/// run at the same time and see some recent state.
class Histogram {
 public:
  Histogram() : counts_(std::make_unique<std::atomic<std::uint64_t>[]>(kBuckets)) {}

  void record(std::int64_t ns) {
    const auto value = static_cast<std::uint64_t>(ns < 0 ? 0 : ns);
    counts_[bucket(value)].fetch_add(1, std::memory_order_relaxed);
    std::uint64_t seen = max_.load(std::memory_order_relaxed);
    while (value > seen && !max_.compare_exchange_weak(seen, value, std::memory_order_relaxed)) {
    }
  }
  /// The value (ns) below or at which the share q of all records lies; 0 when there are none.
  double quantile(double q) const;
  Quantiles quantiles_ms() const;
  std::uint64_t count() const;
  /// Empty again. Records made at the same time may be kept in part.
  void clear();
  std::uint64_t max_ns() const { return max_.load(std::memory_order_relaxed); }

 private:
  friend class HistogramInterval;
  static constexpr int kSubBits = 7;
  static constexpr int kMaxBits = 42;
  static constexpr std::size_t kBuckets = std::size_t{kMaxBits - kSubBits + 1} << kSubBits;

  static std::size_t bucket(std::uint64_t value) {
    if (value >> kMaxBits) return kBuckets - 1;
    const int octave = static_cast<int>(std::bit_width(value >> kSubBits));  // 0: the linear part, one bucket a ns
    if (octave == 0) return static_cast<std::size_t>(value);
    const std::uint64_t within = (value >> (octave - 1)) & ((1u << kSubBits) - 1);
    return (static_cast<std::size_t>(octave) << kSubBits) + static_cast<std::size_t>(within);
  }
  static double middle(std::size_t bucket);
  /// The bucket below or in which the share q of `total` records lies.
  template <class CountOf>
  static std::size_t bucket_of_share(double q, std::uint64_t total, const CountOf& count_of) {
    const auto rank = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::ceil(q * static_cast<double>(total))));
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < kBuckets; ++i)
      if ((seen += count_of(i)) >= rank) return i;
    return kBuckets - 1;
  }

  std::unique_ptr<std::atomic<std::uint64_t>[]> counts_;
  std::atomic<std::uint64_t> max_{0};
};

}  // namespace pavo
