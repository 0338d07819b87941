// The figures of `pavo eval`, for eyes and for programs.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "stages/evaluation/evaluation.h"

namespace pavo {

struct EvaluatedFile {
  std::string path;   ///< as it was given
  std::string label;  ///< short, and different from all others'
  Evaluation evaluation;
};

struct EvalReport {
  std::string truth_path;
  std::size_t truth_poses = 0;
  int step = 10;
  Alignment alignment = Alignment::sim3;
  std::vector<EvaluatedFile> estimates;
};

/// "none", "scale", "SE(3)", "Sim(3)".
const char* alignment_name(Alignment alignment);
/// As the option --align takes it: "none", "scale", "se3", "sim3".
const char* alignment_key(Alignment alignment);

/// The tables of each estimate, and one that compares them where there are several. What has no value is "-".
std::string eval_text(const EvalReport& report);

/// Every number of every estimate; what has no value is null.
nlohmann::ordered_json eval_json(const EvalReport& report);

}  // namespace pavo
