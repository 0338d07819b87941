// Random numbers that are the same on every machine and with every standard library.
#pragma once

#include <cstdint>

namespace pavo {

/// SplitMix64 (Steele, Lea and Flood, OOPSLA 2014): 64 bits of state, one multiply-shift chain a number.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  /// A stream of its own for each frame of a run, whatever was drawn for the other frames.
  static Random for_frame(std::uint64_t run_seed, std::int64_t frame) {
    return Random(Random(run_seed ^ Random(static_cast<std::uint64_t>(frame)).next()).next());
  }

  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  /// Uniform in [0, n), n >= 1; biased by less than n / 2^32.
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(((next() >> 32) * n) >> 32); }
  /// Uniform in [0, 1).
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }

 private:
  std::uint64_t state_;
};

}  // namespace pavo
