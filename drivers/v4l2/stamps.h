// Which of what a driver says about a frame's time and number is to be believed.
#pragma once

#include <cstdint>
#include <optional>

namespace pavo::v4l2 {

struct DriverStamp {
  std::int64_t t_ns = 0;
  bool is_monotonic = false;  ///< the driver says that it is CLOCK_MONOTONIC; else it may be any clock
  bool at_start = false;      ///< of the exposure; else when the last byte had come
};

/// Why a stamp was not believed.
struct StampCounts {
  std::uint64_t other_clock = 0;   ///< the driver does not say that it is CLOCK_MONOTONIC
  std::uint64_t future = 0;        ///< after the frame was taken out
  std::uint64_t before_start = 0;  ///< before the camera was started: of another clock, whatever the driver says
  std::uint64_t backwards = 0;     ///< not after the frame before it
  std::uint64_t all() const { return other_clock + future + before_start + backwards; }
};

/// Times that are never in the future and always later than the one before: the driver's, or, where that cannot be
/// right, the moment in which the frame was taken out. (uvcvideo computes its stamps from the camera's own clock, and
/// has been off by seconds behind a suspend; drivers of old stamp the time of day, and say so or do not.)
class FrameClock {
 public:
  /// The camera was started (again).
  void started(std::int64_t now_ns) { started_ns_ = now_ns; }
  std::int64_t time_of(const DriverStamp& stamp, std::int64_t now_ns);
  const StampCounts& replaced() const { return counts_; }

 private:
  bool believed(const DriverStamp& stamp, std::int64_t now_ns);

  std::int64_t started_ns_ = 0;
  std::optional<std::int64_t> last_ns_;
  StampCounts counts_;
};

/// Frames that the driver lost, by the holes in its count.
class SequenceCheck {
 public:
  /// A new stream: its count may begin anywhere. (The standard says at 0; drivers that never reset it are about.)
  void started() { last_.reset(); }
  /// How many are missing before this one. A count that stands still or runs backwards (drivers that do not count, or
  /// start over on their own) says nothing: 0.
  std::uint64_t lost_before(std::uint32_t sequence);

 private:
  std::optional<std::uint32_t> last_;
};

}  // namespace pavo::v4l2
