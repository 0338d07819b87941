// A pipeline over plain numbers: what the engine's tests run.
#pragma once

#include <cstdint>
#include <mutex>
#include <stdexcept>
#include <vector>

#include "engine/pipeline.h"

namespace pavo::test {

inline constexpr std::int64_t kMs = 1'000'000;

struct Numbers {
  std::int64_t input = 0;
  std::int64_t squared = 0;
  std::int64_t doubled = 0;
  std::int64_t sum = 0;
};

/// 0, 1, ..., count - 1. Those in `unreadable` throw. Live, number k arrives at k * period.
class Counting : public Source<Numbers> {
 public:
  explicit Counting(std::int64_t count, std::vector<std::int64_t> unreadable = {}, std::int64_t period_ns = 0)
      : count_(count), unreadable_(std::move(unreadable)), period_ns_(period_ns) {}

  bool read(FrameInfo& info, Numbers& frame) override {
    if (next_ == count_) return false;
    frame.input = info.source_index = next_++;
    info.t_arrival_ns = 1 + info.source_index * period_ns_;
    for (const std::int64_t bad : unreadable_)
      if (bad == info.source_index) throw std::runtime_error("number " + std::to_string(bad) + " is unreadable");
    return true;
  }
  std::optional<std::int64_t> next_arrival_ns() override {
    if (next_ == count_) return std::nullopt;
    return 1 + next_ * period_ns_;
  }

 private:
  std::int64_t count_;
  std::vector<std::int64_t> unreadable_;
  std::int64_t period_ns_;
  std::int64_t next_ = 0;
};

struct Square {
  void operator()(const std::int64_t& in, std::int64_t& out) const { out = in * in; }
};
struct Double {
  void operator()(const std::int64_t& in, std::int64_t& out) const { out = 2 * in; }
};

/// Work that takes `ns` on the virtual clock.
struct Takes {
  ManualClock& clock;
  std::int64_t ns;
  void operator()(const std::int64_t& in, std::int64_t& out) {
    clock.advance(ns);
    out = in;
  }
  void missed(std::int64_t&) {}
};

/// In order: the running sum of squared + doubled; remembers what it saw.
struct Sum {
  std::int64_t total = 0;
  std::vector<std::uint64_t> seen, missing;

  void operator()(const FrameInfo& info, const std::int64_t& squared, const std::int64_t& doubled, std::int64_t& out) {
    seen.push_back(info.sequence);
    out = total += squared + doubled;
  }
  void missed(const FrameInfo& info, std::int64_t& out) {
    missing.push_back(info.sequence);
    out = total;
  }
};

struct Delivered {
  std::int64_t source_index;
  std::int64_t sum;
  bool failed;
  std::uint64_t gap;
  std::string stage, message;
};

/// Collects what comes out.
inline auto collect(std::vector<Delivered>& into) {
  return [&into](const Numbers& frame, const FrameInfo& info, const Outcome& outcome) {
    into.push_back({info.source_index, frame.sum, outcome.failed, info.gap, std::string(outcome.stage),
                    std::string(outcome.message)});
  };
}

inline PipelineOptions workers(int n) {
  PipelineOptions options;
  options.workers = n;
  return options;
}

}  // namespace pavo::test
