// A wheel's speed as it comes: lines of "t,m/s" from the standard input or a socket, while the camera drives.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "drivers/publishing/descriptor.h"
#include "drivers/publishing/unix_socket.h"
#include "drivers/trajectories/speed_file.h"

namespace pavo {

struct SpeedCounts {
  std::uint64_t samples = 0;  ///< taken
  std::uint64_t refused = 0;  ///< lines that are no sample, or not later than the one before
  std::string first_refused;  ///< for a message; shortened, printable
};

/// The last minutes of speed, and how far the wheel went between two times in them: the integral of the speed, linear
/// between its samples, held constant for at most `hold_s` behind the last and before the first one. Lock held for
/// microseconds; any thread.
class SpeedHistory {
 public:
  static constexpr std::size_t kMost = 1 << 15;

  explicit SpeedHistory(double hold_s = 0.5);
  /// False where it is not later than the one before.
  bool add(const SpeedSample& sample);
  /// Metres, >= 0; NaN where no speed is known for the whole time.
  double distance_m(std::int64_t from_ns, std::int64_t to_ns) const;

 private:
  struct Entry {
    SpeedSample sample;
    double distance_m = 0;  ///< driven from the first sample to this one
  };
  const Entry& entry(std::size_t i) const { return entries_[(first_ + i) % kMost]; }
  double distance_until(std::int64_t t_ns) const;

  double hold_s_;
  mutable std::mutex mutex_;
  std::vector<Entry> entries_;  ///< a ring
  std::size_t first_ = 0, count_ = 0;
};

/// Reads with a thread of its own. "-": the standard input. "unix:PATH": a stream socket that is made here; whoever
/// knows the speed connects to it, one after the other or several at once, and may come and go. t is in seconds of the
/// frames' own clock: a camera's is CLOCK_MONOTONIC.
class LiveSpeed {
 public:
  /// Throws std::runtime_error with one line that begins with "--scale speed=...".
  explicit LiveSpeed(const std::string& where);
  ~LiveSpeed();
  LiveSpeed(const LiveSpeed&) = delete;
  LiveSpeed& operator=(const LiveSpeed&) = delete;

  double distance_m(std::int64_t from_ns, std::int64_t to_ns) const { return history_.distance_m(from_ns, to_ns); }
  SpeedCounts counts() const;

 private:
  struct Feed {
    OwnedDescriptor socket;
    int fd = -1;  ///< the socket's, or the standard input
    std::string line;
  };

  void read_all();
  /// False at its end.
  bool read_from(Feed& feed);
  void take(std::string_view line);

  SpeedHistory history_;
  std::unique_ptr<UnixServer> server_;
  std::vector<Feed> feeds_;  ///< the thread's own
  OwnedDescriptor end_;      ///< an eventfd: the destructor's word to the thread
  mutable std::mutex mutex_;
  SpeedCounts counts_;
  std::jthread thread_;  // last
};

}  // namespace pavo
