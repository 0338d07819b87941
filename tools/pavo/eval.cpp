#include "tools/pavo/eval.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "drivers/trajectories/append_file.h"
#include "drivers/trajectories/trajectory_files.h"
#include "drivers/trajectories/trajectory_svg.h"
#include "stages/evaluation/evaluation.h"
#include "tools/pavo/eval_report.h"

namespace pavo {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string estimate;
  std::string truth;
  std::vector<std::string> more;
  std::string plot;
  std::string json;
  int step = 10;
  std::string align = "sim3";
};

Alignment alignment_of(const std::string& key) {
  for (const Alignment alignment : {Alignment::none, Alignment::scale, Alignment::se3, Alignment::sim3}) {
    if (key == alignment_key(alignment)) return alignment;
  }
  throw std::invalid_argument("--align " + key + ": expected sim3, se3, scale or none");
}

/// "out/trajectory.kitti" of "/home/me/out/trajectory.kitti", as long as no other estimate ends so; else all of it.
std::string label(const std::string& path, const std::vector<std::string>& all) {
  const auto tail = [](const fs::path& p) { return (p.parent_path().filename() / p.filename()).string(); };
  const auto same =
      std::count_if(all.begin(), all.end(), [&](const std::string& other) { return tail(other) == tail(path); });
  return same == 1 ? tail(path) : path;
}

/// A part of KITTI's frames, told by their times, finds its poses through the times.txt that lies beside them.
void take_times_beside(Trajectory& truth, const std::string& path) {
  const fs::path times = fs::path(path).parent_path() / "times.txt";
  if (!truth.t_ns.empty() || !fs::exists(times)) return;
  truth.t_ns = read_times(times.string());
  if (truth.t_ns.size() != truth.T_w_c.size())
    throw std::runtime_error(times.string() + ": " + std::to_string(truth.t_ns.size()) + " times for the " +
                             std::to_string(truth.T_w_c.size()) + " poses of " + path + ": expected one per pose");
}

EvaluatedFile evaluate_file(const std::string& path, const Trajectory& estimate, Trajectory truth,
                            const Options& options) {
  if (estimate.T_w_c.size() != truth.T_w_c.size() && !estimate.t_ns.empty()) take_times_beside(truth, options.truth);
  EvaluationOptions how;
  how.step = options.step;
  try {
    return {path, path, evaluate(estimate, truth, how)};
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(path + " against " + options.truth + ": " + error.what());
  }
}

PlotCurve curve(const EvaluatedFile& file, const Trajectory& estimate, Alignment alignment, std::size_t index) {
  std::vector<std::string> colors{kPavoColor, kGeometricColor};
  colors.insert(colors.end(), std::begin(kMoreColors), std::end(kMoreColors));
  return {file.label, colors[index % colors.size()],
          transformed(file.evaluation.aligned(alignment).similarity, estimate), false};
}

std::string plot_note(Alignment alignment) {
  const std::string who = "Estimates aligned to the ground truth by ";
  switch (alignment) {
    case Alignment::none:
      return who + "their first poses only";
    case Alignment::scale:
      return who + "their first poses and one scale";
    default:
      return who + alignment_name(alignment);
  }
}

int run(const Options& options) {
  const Alignment alignment = alignment_of(options.align);
  std::vector<std::string> paths{options.estimate};
  paths.insert(paths.end(), options.more.begin(), options.more.end());

  const Trajectory truth = read_trajectory(options.truth);
  EvalReport report{options.truth, truth.T_w_c.size(), options.step, alignment, {}};
  TrajectoryPlot plot{"", plot_note(alignment), {{"ground truth", kTruthColor, truth, true}}};
  for (const std::string& path : paths) {
    const Trajectory estimate = read_trajectory(path);
    report.estimates.push_back(evaluate_file(path, estimate, truth, options));
    report.estimates.back().label = label(path, paths);
    plot.curves.push_back(curve(report.estimates.back(), estimate, alignment, plot.curves.size() - 1));
  }

  if (!options.json.empty()) write_whole_file(options.json, eval_json(report).dump(2) + "\n");
  if (!options.plot.empty()) write_trajectory_svg(options.plot, plot);
  std::cout << eval_text(report) << std::flush;
  if (!std::cout) throw std::runtime_error("standard output: the tables could not be written");
  return 0;
}

}  // namespace

void register_eval(CLI::App& app, int& status) {
  const auto options = std::make_shared<Options>();
  CLI::App* eval = app.add_subcommand("eval", "Compare trajectories with the true one: ATE, KITTI's errors, RPE, RMSE");
  eval->add_option("ESTIMATE", options->estimate, "trajectory in KITTI's (12 numbers a line) or TUM's format (8)")
      ->required()
      ->type_name("");
  eval->add_option("GROUNDTRUTH", options->truth, "the true one, in either format")->required()->type_name("");
  eval->add_option("MORE", options->more, "more estimates of the same path")->type_name("");
  eval->add_option("--plot", options->plot, "draw the paths from above")->type_name("FILE.svg");
  eval->add_option("--json", options->json, "write all numbers")->type_name("FILE");
  eval->add_option("--step", options->step, "KITTI's segments start at every N-th frame")
      ->type_name("N")
      ->check(CLI::Range(1, 1'000'000).description(""))
      ->capture_default_str();
  eval->add_option("--align", options->align, "how the plot and the comparison lay estimates over the truth")
      ->type_name("sim3|se3|scale|none")
      ->check(CLI::IsMember({"sim3", "se3", "scale", "none"}).description(""))
      ->capture_default_str();
  eval->footer("Example: pavo eval out/trajectory.kitti sequences/05/poses.txt --plot path.svg --json errors.json");
  eval->callback([options, &status] { status = run(*options); });
}

}  // namespace pavo
