// `--scale`: from its text to step lengths.
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "drivers/sequences/sequence.h"
#include "pavo/config.h"
#include "stages/pose/scale.h"

namespace pavo {

struct Scale {
  std::shared_ptr<const StepLength> step_length;
  std::string description;  ///< for the report: where the scale comes from
  /// Of a speed that is listened to, what came so far: for the report.
  std::function<nlohmann::ordered_json()> counts = {};
};

/// `info` is of `source`, which is opened once more where another ground truth is named. Throws std::runtime_error,
/// naming the option, the file or what the sequence lacks.
Scale scale_of(const Config& config, const std::string& source, const SequenceInfo& info);

}  // namespace pavo
