// The engine's options from the configuration.
#pragma once

#include <string>
#include <vector>

#include "engine/runtime.h"
#include "pavo/config.h"

namespace pavo {

/// Throws std::runtime_error with the key, what was expected and what was there.
PipelineOptions engine_options(const Config& config);

/// "odometry=0 scan=0,1": the stages and the workers that they may run on.
std::vector<PipelineOptions::Affinity> parse_affinity(const std::string& text);
/// "0,1" or "".
std::vector<int> parse_cpus(const std::string& text);

}  // namespace pavo
