#include "engine/histogram.h"

#include <algorithm>
#include <cmath>

#include "engine/histogram_interval.h"

namespace pavo {

double Histogram::middle(std::size_t bucket) {
  const auto octave = static_cast<int>(bucket >> kSubBits);
  const auto within = static_cast<double>(bucket & ((1u << kSubBits) - 1));
  if (octave == 0) return within;
  const double width = std::ldexp(1.0, octave - 1);
  return ((1u << kSubBits) + within + 0.5) * width - 0.5;
}

std::uint64_t Histogram::count() const {
  std::uint64_t n = 0;
  for (std::size_t i = 0; i < kBuckets; ++i) n += counts_[i].load(std::memory_order_relaxed);
  return n;
}

void Histogram::clear() {
  for (std::size_t i = 0; i < kBuckets; ++i) counts_[i].store(0, std::memory_order_relaxed);
  max_.store(0, std::memory_order_relaxed);
}

double Histogram::quantile(double q) const {
  const std::uint64_t n = count();
  if (n == 0) return 0;
  const std::size_t at =
      bucket_of_share(q, n, [this](std::size_t i) { return counts_[i].load(std::memory_order_relaxed); });
  const auto max = static_cast<double>(max_ns());
  return at + 1 == kBuckets ? max : std::min(middle(at), max);
}

Quantiles Histogram::quantiles_ms() const {
  constexpr double kMs = 1e-6;
  return {quantile(0.5) * kMs,
          quantile(0.9) * kMs,
          quantile(0.99) * kMs,
          quantile(0.999) * kMs,
          static_cast<double>(max_ns()) * kMs,
          count()};
}

Quantiles HistogramInterval::look_ms() {
  before_.resize(Histogram::kBuckets);
  since_.resize(Histogram::kBuckets);
  std::uint64_t n = 0;
  for (std::size_t i = 0; i < since_.size(); ++i) {
    const std::uint64_t now = histogram_->counts_[i].load(std::memory_order_relaxed);
    since_[i] = now >= before_[i] ? now - before_[i] : now;  // it may have been emptied
    before_[i] = now;
    n += since_[i];
  }
  if (n == 0) return {};
  const auto quantile_ms = [&](double q) {
    return 1e-6 * Histogram::middle(Histogram::bucket_of_share(q, n, [this](std::size_t i) { return since_[i]; }));
  };
  return {quantile_ms(0.5), quantile_ms(0.9), quantile_ms(0.99), quantile_ms(0.999), quantile_ms(1), n};
}

}  // namespace pavo
