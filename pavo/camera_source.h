// A camera as the engine's source.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "drivers/v4l2/live_camera.h"
#include "engine/histogram.h"
#include "engine/pipeline.h"
#include "pavo/frame.h"

namespace pavo {

/// Frames count from 0 as they are admitted; t_capture_ns is CLOCK_MONOTONIC, as t_sensor_ns. Their latency begins with
/// the driver's stamp, so that what it holds back is in it; how much that is, until they are taken out of the driver,
/// is measured here.
class CameraSource final : public Source<Frame> {
 public:
  explicit CameraSource(v4l2::LiveCamera& camera) : camera_(camera) {}

  bool holds_newest() const override { return true; }
  std::optional<std::int64_t> next_arrival_ns() override { return std::nullopt; }
  void interrupt() override { camera_.interrupt(); }

  bool read(FrameInfo& info, Frame& frame) override {
    v4l2::CameraFrame taken;
    try {
      do {  // a frame that lay ready goes with the camera that is pulled out at this moment
        if (!camera_.wait()) return false;
      } while (!camera_.take(frame.encoded, taken));
    } catch (const v4l2::FrameFault&) {
      describe(taken, info, frame);
      throw;
    }
    describe(taken, info, frame);
    return true;
  }

  std::uint64_t unread() override {
    const std::uint64_t lying_ready = camera_.stop();
    return lying_ready + stale_since_last();
  }

  /// From the driver's stamp to the moment in which the frame was taken out of it.
  const Histogram& capture_to_dequeue() const { return capture_to_dequeue_; }

 private:
  std::uint64_t stale_since_last() {
    const std::uint64_t all = camera_.stale();
    return all - std::exchange(stale_, all);
  }

  void describe(const v4l2::CameraFrame& taken, FrameInfo& info, Frame& frame) {
    frame.name.clear();
    info.source_index = next_++;
    info.t_capture_ns = info.t_sensor_ns = info.t_arrival_ns = taken.t_sensor_ns;
    info.gap = taken.lost_before;
    info.stale = stale_since_last();
    capture_to_dequeue_.record(taken.t_dequeue_ns - taken.t_sensor_ns);
  }

  v4l2::LiveCamera& camera_;
  std::int64_t next_ = 0;
  std::uint64_t stale_ = 0;
  Histogram capture_to_dequeue_;
};

}  // namespace pavo
