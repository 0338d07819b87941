// Everything that one call of `pavo bench` has found, as JSON and as text.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/pavo/bench_machine.h"
#include "tools/pavo/bench_run.h"

namespace pavo {

/// One load, measured several times.
struct BenchedLoad {
  BenchRun median;
  std::vector<BenchRun> repeats;
  std::vector<BenchSample> samples;  ///< of the first repeat, for the curve over time
  std::vector<double> all_ms;        ///< the age of every frame of all repeats, for the distribution
};

struct BenchResult {
  Machine machine;
  std::string source, mode;  ///< "live" or "every-frame"
  int frames = 0, width = 0, height = 0, workers = 0;
  double seconds = 0;
  std::vector<double> capacities_fps;  ///< one of each repeat
  double capacity_fps = 0;             ///< their median
  BenchRun full_speed;                 ///< the median, for its stages
  std::vector<BenchedLoad> loads;
  OtherWork::Share others;  ///< while it was measured
  std::vector<std::string> warnings;
};

nlohmann::ordered_json bench_json(const BenchResult& result, const nlohmann::ordered_json& config);
std::string bench_text(const BenchResult& result);

/// "of 3 runs" figures: the smallest and the largest of what `get` gives.
struct RunSpread {
  double least = 0, most = 0;
};
template <class Get>
RunSpread spread_of(const std::vector<BenchRun>& runs, const Get& get) {
  RunSpread spread{get(runs.front()), get(runs.front())};
  for (const BenchRun& run : runs) {
    spread.least = std::min(spread.least, get(run));
    spread.most = std::max(spread.most, get(run));
  }
  return spread;
}

}  // namespace pavo
