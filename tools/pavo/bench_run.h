// One run of the pipeline under one load.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/histogram.h"
#include "engine/trace.h"
#include "pavo/config.h"
#include "tools/pavo/bench_frames.h"
#include "types/camera.h"

namespace pavo {

struct StageFigures {
  std::string name;
  Quantiles wait_ms, service_ms, cpu_ms;
};

/// What one run measured behind its warm-up, or the medians of several.
struct BenchRun {
  double load_percent = 0;  ///< of the capacity; 0: unknown
  double offered_fps = 0, done_fps = 0;
  std::int64_t done = 0, dropped = 0;
  Quantiles end_to_end_ms;  ///< intended arrival to the end of delivery, of the frames that were taken
  Quantiles age_ms;         ///< sensor to the end of delivery; frames in memory are there when they were taken
  std::vector<StageFigures> stages;
};

/// What the plot is made of: every frame, not only its place in a histogram.
struct BenchSample {
  double t_s = 0;  ///< of its delivery, since the run's first intended arrival
  double age_ms = 0;
};

struct BenchLoad {
  double rate_hz = 0;  ///< 0: full speed, every frame
  double seconds = 0;
  Trace* trace = nullptr;  ///< written meanwhile, as `pavo run --trace` does
};

/// Warms up, measures `seconds`, and lets all frames out. Throws std::runtime_error where a frame fails: the figures
/// would mean nothing.
BenchRun bench_run(const Config& config, const Camera& camera, const BenchFrames& frames, const BenchLoad& load,
                   std::vector<BenchSample>& samples);

/// Each figure the median of those of the runs (one or more, of the same load and the same stages).
BenchRun median_of(const std::vector<BenchRun>& runs);

}  // namespace pavo
