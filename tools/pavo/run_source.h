// What `pavo run` reads from: a recorded or rendered sequence, or a camera.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "drivers/sequences/sequence.h"
#include "engine/pipeline.h"
#include "pavo/config.h"
#include "pavo/frame.h"

namespace pavo {

class RunSource {
 public:
  virtual ~RunSource() = default;
  virtual const SequenceInfo& info() const = 0;
  /// Runs the pipeline until the source ends or the pipeline is stopped. Throws what ended it otherwise.
  virtual void drive(Pipeline<Frame>& pipeline) = 0;
  /// When a frame of the source that was dropped was taken. Any thread.
  virtual std::int64_t capture_time_ns(std::int64_t index) const = 0;
  /// How many lines the trajectory has: one for each frame of a sequence, and for each admitted frame of a camera.
  virtual std::int64_t lines(const Counts& counts) const = 0;
  /// 0: unknown.
  virtual double rate_hz() const = 0;

  virtual std::vector<std::string> warnings() const { return {}; }  ///< at any time; any thread

  // --- what a camera has to tell; nothing for sequences
  virtual nlohmann::ordered_json report() const { return {}; }  ///< at any time; any thread
  virtual std::string summary() const { return {}; }
};

/// Opens what SOURCE names; a camera is started, and `live` says whether its newest frames are wanted or all. Throws
/// std::runtime_error of one line. `clock` outlives the source.
std::unique_ptr<RunSource> open_run_source(const std::string& source, const Config& config, const Clock& clock);

}  // namespace pavo
