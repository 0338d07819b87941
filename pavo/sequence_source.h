// A recorded sequence as the engine's source.
#pragma once

#include <mutex>
#include <optional>
#include <vector>

#include "drivers/sequences/sequence.h"
#include "engine/pipeline.h"
#include "pavo/frame.h"

namespace pavo {

/// Live, the frames arrive at their own times, counted from the first call; else as fast as there is room.
class SequenceSource : public Source<Frame> {
 public:
  SequenceSource(Sequence& sequence, bool live, const Clock& clock) : sequence_(sequence), live_(live), clock_(clock) {}

  bool read(FrameInfo& info, Frame& frame) override {
    const std::optional<std::int64_t> arrival = live_ ? next_arrival_ns() : clock_.now_ns();
    info.t_arrival_ns = arrival.value_or(0);
    const auto take_over = [&] {
      remember(stamp_);
      info.source_index = stamp_.index;
      info.t_capture_ns = stamp_.t_capture_ns;
      frame.name = stamp_.name;
    };
    try {
      if (!sequence_.read(frame.encoded, stamp_)) return false;
      take_over();
      return true;
    } catch (...) {
      take_over();
      throw;
    }
  }

  std::optional<std::int64_t> next_arrival_ns() override {
    const std::optional<FrameStamp> next = sequence_.peek();
    if (!next) return std::nullopt;
    if (!offset_ns_) offset_ns_ = clock_.now_ns() - next->t_capture_ns;
    return next->t_capture_ns + *offset_ns_;
  }

  /// When a frame that was read (and perhaps dropped) was taken. Any thread.
  std::int64_t capture_time_ns(std::int64_t index) const {
    const std::lock_guard lock(mutex_);
    return times_.at(static_cast<std::size_t>(index));
  }

 private:
  void remember(const FrameStamp& stamp) {
    const std::lock_guard lock(mutex_);
    times_.resize(static_cast<std::size_t>(stamp.index) + 1, stamp.t_capture_ns);
  }

  Sequence& sequence_;
  bool live_;
  const Clock& clock_;
  FrameStamp stamp_;
  mutable std::mutex mutex_;
  std::vector<std::int64_t> times_;
  std::optional<std::int64_t> offset_ns_;  ///< from the sequence's time to the engine's
};

}  // namespace pavo
