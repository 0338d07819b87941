// trajectory.svg of a run: ground truth red, plain geometry green, pavo blue.
#pragma once

#include <optional>
#include <string>

#include "drivers/sequences/sequence.h"
#include "pavo/config.h"
#include "stages/evaluation/evaluation.h"
#include "tools/pavo/run_outputs.h"

namespace pavo {

/// Over the frames that have ground truth; nothing where fewer than two do.
std::optional<Evaluation> evaluate_run(const Trajectory& estimate, const SequenceInfo& info);

/// Estimates are aligned by SE(3) where they are metric, else by Sim(3); the legend says which.
void write_run_plot(const std::string& path, const SequenceInfo& info, const RunOutputs& outputs, const Config& config,
                    bool metric);

}  // namespace pavo
