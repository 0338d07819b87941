#include "tools/pavo/run_plot.h"

#include "drivers/trajectories/trajectory_svg.h"
#include "stages/evaluation/alignment.h"
#include "stages/evaluation/association.h"

namespace pavo {
namespace {

// The poses of the frames that have a true one, each beside it.
PosePairs pairs_of(const Trajectory& estimate, const SequenceInfo& info) {
  PosePairs pairs;
  for (std::size_t i = 0; i < info.groundtruth_frames.size(); ++i) {
    const auto frame = static_cast<std::size_t>(info.groundtruth_frames[i]);
    if (frame >= estimate.T_w_c.size()) break;  // the run was stopped before
    pairs.estimate.push_back(estimate.T_w_c[frame]);
    pairs.truth.push_back(info.groundtruth->T_w_c[i]);
  }
  return pairs;
}

Trajectory aligned(const Trajectory& estimate, const SequenceInfo& info, bool metric) {
  if (!info.groundtruth) return estimate;
  const PosePairs pairs = pairs_of(estimate, info);
  if (pairs.truth.size() < 2) return estimate;
  return transformed(align(pairs, metric ? Alignment::se3 : Alignment::sim3), estimate);
}

}  // namespace

std::optional<Evaluation> evaluate_run(const Trajectory& estimate, const SequenceInfo& info) {
  if (!info.groundtruth) return std::nullopt;
  const PosePairs pairs = pairs_of(estimate, info);
  if (pairs.truth.size() < 2) return std::nullopt;
  return evaluate({.T_w_c = pairs.estimate, .t_ns = {}}, {.T_w_c = pairs.truth, .t_ns = {}});
}

void write_run_plot(const std::string& path, const SequenceInfo& info, const RunOutputs& outputs, const Config& config,
                    bool metric) {
  TrajectoryPlot plot;
  plot.title = info.path;
  if (info.groundtruth) {
    plot.curves.push_back({"ground truth", kTruthColor, *info.groundtruth, true});
    plot.note = metric ? "estimates aligned by SE(3)" : "estimates aligned by Sim(3)";
  } else if (!metric) {
    plot.unit = "units";
    plot.note = uses_keyframes(config) ? "no metric scale: one unit is the first baseline"
                                       : "no metric scale: one unit is one step";
  }
  if (config.odometry.compare)
    plot.curves.push_back({"geometric", kGeometricColor, aligned(outputs.geometric(), info, metric)});
  plot.curves.push_back({"pavo", kPavoColor, aligned(outputs.trajectory(), info, metric)});
  write_trajectory_svg(path, plot);
}

}  // namespace pavo
