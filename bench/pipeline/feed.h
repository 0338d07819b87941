// When frames come, and when they are done.
#pragma once

#include <cstdint>
#include <vector>

namespace pavo::bench {

/// Frame k is meant to arrive at start + k / rate; its latency counts from there, whenever it is taken (no coordinated
/// omission). One thread at a time calls next(), one at a time done(). Allocates in the constructor only.
class Feed {
 public:
  /// rate_hz 0: as fast as they are taken. The first `warm_up` frames are not counted.
  Feed(std::int64_t frames, double rate_hz, std::int64_t warm_up);

  /// The next frame; sleeps until it arrives. -1: there are no more.
  std::int64_t next();
  void done(std::int64_t k);

  std::int64_t frames() const { return frames_; }
  std::int64_t arrival_ns(std::int64_t k) const;
  double frames_per_second() const;
  /// In milliseconds, sorted.
  std::vector<double> latencies_ms() const;

 private:
  std::int64_t frames_, warm_up_;
  double rate_hz_;
  std::int64_t start_ns_ = 0, next_ = 0;
  std::vector<std::int64_t> arrival_, done_;
};

}  // namespace pavo::bench
