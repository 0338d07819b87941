// report.json: what was run, how it went, how long everything took.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/runtime.h"
#include "pavo/config.h"
#include "stages/evaluation/evaluation.h"
#include "tools/pavo/run_outputs.h"

namespace pavo {

struct RunSummary {
  const Config& config;
  std::string source, layout, calibration, groundtruth;
  std::string scale;  ///< in words: "unit", "groundtruth (poses.txt)", ...
  const Runtime& runtime;
  double wall_s = 0;
  const RunOutputs& outputs;
  std::int64_t not_drawn = 0;
  std::optional<Evaluation> evaluation, geometric_evaluation;
  std::string trajectory_sha256;
  std::vector<std::string> warnings;
  std::string camera_summary;
  nlohmann::ordered_json camera;             ///< null: no camera was there
  nlohmann::ordered_json publishing, speed;  ///< null: not asked for
};

nlohmann::ordered_json report(const RunSummary& run);

// --- parts of it, which the metrics of every second have, too
/// {p50, p90, p99, p999, max}
nlohmann::ordered_json quantiles_json(const Quantiles& q);
nlohmann::ordered_json quantiles_json(const Histogram& histogram);
nlohmann::ordered_json frames_json(const Counts& counts, const Runtime& runtime);
nlohmann::ordered_json ring_json(const Runtime& runtime, const Quantiles& in_flight_ms);
void add_counts(nlohmann::ordered_json& stage, const StageMetrics& metrics);

}  // namespace pavo
