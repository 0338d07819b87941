// What `pavo bench` measures with: frames that lie in memory, and a source that hands them out at a pace of its own.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/sequences/sequence.h"
#include "engine/pipeline.h"
#include "pavo/frame.h"

namespace pavo {

/// The first frames of a sequence as it delivers them (encoded, where they are), so that a run reads no file and yet
/// decodes as always. Played forth and back, the camera moves as it may for as long as one likes.
class BenchFrames {
 public:
  /// Reads up to `count` frames. Throws std::runtime_error (one line) where one cannot be read, or there are none.
  BenchFrames(Sequence& sequence, int count);

  std::size_t size() const { return frames_.size(); }
  /// The frame that is shown at place k of the endless run 0, 1, ..., n-1, n-2, ..., 1, 0, 1, ...
  const EncodedImage& at(std::int64_t k) const;

 private:
  std::vector<EncodedImage> frames_;
};

/// Frame k is meant to arrive at start + k / rate, whatever the pipeline is doing then, and its latency counts from
/// there: a stall delays what comes behind it, and that is seen (no coordinated omission). Without a rate, frames come
/// as fast as they are taken.
class PacedSource final : public Source<Frame> {
 public:
  struct Pace {
    double rate_hz = 0;  ///< 0: as fast as they are taken
    bool live = false;   ///< the engine waits for arrivals itself
    std::int64_t frames = 0;
    std::int64_t until_ns = 0;  ///< without a rate: no frame after this much time; 0: no limit
    std::int64_t at_least = 0;  ///< but so many in any case, however slow the machine
  };

  PacedSource(const BenchFrames& frames, const Pace& pace, Clock& clock);

  bool read(FrameInfo& info, Frame& frame) override;
  std::optional<std::int64_t> next_arrival_ns() override;

 private:
  std::int64_t arrival_ns(std::int64_t k) const;
  void begin();

  const BenchFrames& frames_;
  Pace pace_;
  Clock& clock_;
  EventCount nobody_notifies_;
  std::int64_t start_ns_ = 0, next_ = 0;
};

}  // namespace pavo
