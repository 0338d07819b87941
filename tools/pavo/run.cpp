#include "tools/pavo/run.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <utility>

#include "drivers/sequences/directory.h"
#include "drivers/sequences/sequence.h"
#include "drivers/trajectories/sha256.h"
#include "drivers/trajectories/trajectory_files.h"
#include "engine/clock.h"
#include "engine/trace.h"
#include "pavo/config.h"
#include "pavo/odometry_pipeline.h"
#include "pavo/simd.h"
#include "tools/pavo/frame_feed.h"
#include "tools/pavo/metrics_file.h"
#include "tools/pavo/movie.h"
#include "tools/pavo/progress.h"
#include "tools/pavo/report.h"
#include "tools/pavo/run_outputs.h"
#include "tools/pavo/run_plot.h"
#include "tools/pavo/run_publishing.h"
#include "tools/pavo/run_source.h"
#include "tools/pavo/scale_option.h"
#include "tools/pavo/signals.h"
#include "tools/pavo/usage_error.h"

namespace pavo {
namespace {

struct RunCall {
  std::string source, out, config_file, draw, trace, metrics;
  /// Keys that options set, over what the config file says: option, key, value.
  struct Override {
    std::string option, key, value;
  };
  std::vector<Override> overrides;
  std::function<bool(const std::string& option)> given;  ///< on the command line
};

Config resolved_config(const RunCall& call) {
  Config config;
  if (!call.config_file.empty()) read_config(call.config_file, config);
  for (const RunCall::Override& o : call.overrides) {
    try {
      set_from_text(config, o.key, o.value, o.option);
    } catch (const std::exception& e) {
      throw UsageError(e.what());
    }
  }
  try {
    settle_camera_height(config);
    check_estimator(config);
    force_simd(config.engine.simd);
  } catch (const std::exception& e) {
    throw UsageError(e.what());
  }
  if (config.source.mode == "auto") config.source.mode = is_camera(call.source) ? "live" : "every-frame";
  return config;
}

/// A folder inside the recording with pictures in it.
bool holds_pictures_of(const std::string& source, const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (folder.empty() || !fs::is_directory(folder, error) || !fs::is_directory(source, error)) return false;
  const fs::path within = fs::relative(folder, source, error);
  return !error && !within.empty() && *within.begin() != ".." && !list_images(folder).empty();
}

// An empty name is a shell variable that was never set; outputs in the recording's own folder would overwrite it.
void check_places(const RunCall& call) {
  if (call.source.empty())
    throw UsageError("SOURCE is empty: expected a folder, a video file, a camera, or `synthetic`");
  for (const auto& [option, value] : {std::pair("--out", call.out), std::pair("--draw", call.draw),
                                      std::pair("--trace", call.trace), std::pair("--metrics", call.metrics)}) {
    const bool given = call.given && call.given(option);
    if (given && value.empty()) throw UsageError(std::string(option) + " is empty: expected where to write");
    std::error_code not_both;
    if (!value.empty() && std::filesystem::equivalent(value, call.source, not_both))
      throw UsageError(std::string(option) + " " + value + ": this is SOURCE itself, whose files would be overwritten");
  }
  if (holds_pictures_of(call.source, call.draw))
    throw UsageError("--draw " + call.draw + ": SOURCE's pictures are there, and would be overwritten");
  if (call.given && call.given("--config") && call.config_file.empty())
    throw UsageError("--config is empty: expected a TOML file");
}

void check_times(const Config& config, const SequenceInfo& info) {
  if (info.has_times) return;
  const std::string advice = " needs the frames' times, and " + info.path + " has none: give them with --rate HZ";
  if (config.source.mode == "live") throw UsageError("--live" + advice);
  if (config.odometry.scale.starts_with("speed")) throw UsageError("--scale speed" + advice);
}

// Of the film that is drawn: the source's where it is known; to a hundredth, and no more than a film can have, since
// MPEG-4 counts time in at most 65535 parts of a second.
double film_rate_hz(const RunSource& source, const Config& config) {
  double rate_hz = 10;
  if (config.source.rate_hz > 0) rate_hz = config.source.rate_hz;
  if (source.rate_hz() > 0) rate_hz = source.rate_hz();
  return std::clamp(std::round(100 * rate_hz) / 100, 0.1, 600.0);
}

std::string accuracy_line(const char* who, const Evaluation& e) {
  std::string line =
      fmt::format("  {}: ATE {:.3f} m (Sim3, scale {:.4f})", who, e.sim3.ate_m.rmse, e.sim3.similarity.scale);
  if (const auto& all = e.raw.segments.all)
    line += fmt::format(", t_rel {:.2f} %, r_rel {:.2f} deg/100 m over {} segments", all->t_rel_percent,
                        all->r_rel_deg_per_100m, all->segments);
  return line;
}

void print_summary(const RunSummary& run, const std::string& out) {
  const Counts c = run.runtime.counts();
  fmt::print("{} ({}): {} frames in {:.2f} s, {:.0f} a second: {} done, {} failed, {} dropped\n", run.source,
             run.layout, c.in, run.wall_s, static_cast<double>(c.done + c.failed) / std::max(run.wall_s, 1e-9), c.done,
             c.failed, c.dropped);
  const PoseCounts& p = run.outputs.poses();
  fmt::print("  poses: {} tracked, {} standing, {} coasting{}; scale: {}\n", p.tracked, p.standing, p.coasting,
             p.relocalising > 0 ? fmt::format(", {} where a new map began", p.relocalising) : "", run.scale);
  if (!run.camera_summary.empty()) fmt::print("  camera: {}\n", run.camera_summary);
  if (run.config.people.enabled)
    fmt::print("  people: {} seen, {} features on them dropped\n", run.outputs.people().seen,
               run.outputs.people().features_dropped);
  if (run.evaluation) fmt::print("{}\n", accuracy_line("against the ground truth", *run.evaluation));
  if (run.geometric_evaluation) fmt::print("{}\n", accuracy_line("without removing people", *run.geometric_evaluation));
  if (!out.empty()) fmt::print("  written: {}/trajectory.svg, trajectory.kitti, frames.csv, report.json, ...\n", out);
  for (const std::string& warning : run.warnings) fmt::print(stderr, "pavo: warning: {}\n", warning);
}

std::vector<std::string> warnings_of(const Counts& counts, const RunOutputs& outputs) {
  std::vector<std::string> warnings;
  if (counts.failed > 0)
    warnings.push_back(fmt::format("{} of {} frames failed and have the motion model's pose; the first: {}",
                                   counts.failed, counts.in, outputs.first_failure()));
  if (outputs.people().frames_short > 0)
    warnings.push_back(
        fmt::format("in {} frames too few features were left beside the people", outputs.people().frames_short));
  return warnings;
}

// One run, from the opened source to the written report. Whatever ends it, what was computed is written first; then the
// first error is told.
class Run {
 public:
  Run(const RunCall& call, const Config& config)
      : call_(call),
        config_(config),
        source_(open_run_source(call.source, config, clock_)),
        camera_(camera_of(source_->info(), config)),
        scale_(scale_of(config, call.source, source_->info())),
        odometry_(config, camera_, scale_.step_length, Input::encoded, clock_),
        movie_(call.draw.empty()
                   ? nullptr
                   : std::make_unique<Movie>(call.draw, camera_, film_rate_hz(*source_, config), !is_live())),
        publishing_(config.output.publish, clock_),
        outputs_({.folder = call.out,
                  .people = config.people.enabled,
                  .compare = config.odometry.compare,
                  .map = uses_keyframes(config),
                  .keep_all = source_->info().groundtruth.has_value()},
                 [this](std::int64_t index) { return source_->capture_time_ns(index); }) {
    engine().deliver([this](const Frame& frame, const FrameInfo& info, const Outcome& outcome) {
      publishing_.deliver(frame, info);  // first: nothing is worth less when it is late
      outputs_.deliver(frame, info, outcome);
      offer_to_movie(frame, info, outcome);
    });
    if (!call.trace.empty()) {
      trace_ = std::make_unique<Trace>(call.trace);
      engine().trace_to(*trace_);
    }
    engine().prepare();
    engine().on_hang([this](const HungStage& hung) { end_process(hung); });
  }

  Pipeline<Frame>& engine() { return odometry_.engine(); }

  void drive() {
    start_ = std::chrono::steady_clock::now();
    if (!call_.metrics.empty())
      metrics_ = std::make_unique<MetricsFile>(call_.metrics, engine().runtime(), [this] { return source_->report(); });
    const auto progress = make_progress();
    try {
      source_->drive(engine());
    } catch (const RunError& e) {
      ended_by_ = std::make_exception_ptr(std::runtime_error(call_.source + ": " + e.what()));
    } catch (...) {
      if (!ended_by_) ended_by_ = std::current_exception();
    }
    wall_s_ = seconds_since_start();
  }

  int conclude(bool interrupted) {
    const Counts counts = engine().counts();
    attempt([&] { outputs_.finish(source_->lines(counts), interrupted || ended_by_); });
    attempt([&] {
      if (movie_) movie_->finish();
    });
    attempt([&] {
      if (metrics_) metrics_->finish();
    });
    attempt([&] {
      if (trace_) trace_->finish();
    });
    RunSummary summary = summarise(counts);
    if (!call_.out.empty()) write_files(summary);
    if (ended_by_) std::rethrow_exception(ended_by_);
    if (!interrupted) check_something_came(counts);
    print_summary(summary, call_.out);
    return 0;
  }

 private:
  bool is_live() const { return config_.source.mode == "live"; }

  static const Camera& camera_of(const SequenceInfo& info, const Config& config) {
    if (!info.camera)
      throw std::runtime_error(info.path + ": no calibration was found for it; give one with --calibration FILE");
    check_times(config, info);
    return *info.camera;
  }

  double seconds_since_start() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

  std::unique_ptr<Progress> make_progress() {
    if (is_live()) {
      auto look = std::make_shared<RunLook>(engine().runtime(), [this] { return source_->report(); });
      return std::make_unique<Progress>(call_.source, [look] { return look->line(); });
    }
    return std::make_unique<Progress>(call_.source, source_->info().frame_count, [this] {
      const Counts c = engine().counts();
      return static_cast<std::int64_t>(c.in - c.in_flight);
    });
  }

  // A stage hangs, and no thread that is in it can be ended: what was computed is written, and the process goes, by the
  // watchdog's thread. The main one waits for what does not come.
  [[noreturn]] void end_process(const HungStage& hung) {
    ended_by_ = std::make_exception_ptr(std::runtime_error(call_.source + ": " + hung.message));
    wall_s_ = seconds_since_start();
    std::string error = hung.message;
    try {
      if (hung.stage != "delivery") conclude(false);
    } catch (const std::exception& e) {
      error = e.what();
    }
    fmt::print(stderr, "{}pavo: {}\n", isatty(STDERR_FILENO) ? "\r\033[K" : "", error);
    std::fflush(nullptr);
    std::_Exit(1);
  }

  void offer_to_movie(const Frame& frame, const FrameInfo& info, const Outcome& outcome) {
    if (!movie_) return;
    try {
      movie_->offer(frame, info, outcome);
    } catch (...) {  // ends the run as a signal does: what was admitted is still written
      ended_by_ = std::current_exception();
      movie_.reset();
      engine().stop();
    }
  }

  // The outputs go on as far as they can; the first error is the one to tell.
  template <class Step>
  void attempt(Step&& step) {
    try {
      step();
    } catch (...) {
      if (!ended_by_) ended_by_ = std::current_exception();
    }
  }

  RunSummary summarise(const Counts& counts) {
    const SequenceInfo& info = source_->info();
    RunSummary summary{.config = config_,
                       .source = call_.source,
                       .layout = info.layout,
                       .calibration = info.calibration_source,
                       .groundtruth = info.groundtruth ? info.groundtruth_source : "",
                       .scale = scale_.description,
                       .runtime = engine().runtime(),
                       .wall_s = wall_s_,
                       .outputs = outputs_,
                       .not_drawn = movie_ ? movie_->passed_by() : 0,
                       .evaluation = evaluate_run(outputs_.trajectory(), info),
                       .geometric_evaluation = {},
                       .trajectory_sha256 = {},
                       .warnings = warnings_of(counts, outputs_),
                       .camera_summary = source_->summary(),
                       .camera = source_->report()};
    for (std::string& warning : source_->warnings()) summary.warnings.push_back(std::move(warning));
    summary.publishing = publishing_.report();
    for (std::string& warning : publishing_.warnings()) summary.warnings.push_back(std::move(warning));
    if (scale_.counts) summary.speed = scale_.counts();
    for (const std::string& refusal : engine().runtime().refusals()) summary.warnings.push_back(refusal);
    if (trace_ && trace_->lost() > 0)
      summary.warnings.push_back(
          fmt::format("{}: {} events came too fast and are missing", call_.trace, trace_->lost()));
    if (config_.odometry.compare) summary.geometric_evaluation = evaluate_run(outputs_.geometric(), info);
    return summary;
  }

  void write_files(RunSummary& summary) {
    const std::filesystem::path folder(call_.out);
    attempt([&] { summary.trajectory_sha256 = sha256_of_file(folder / "trajectory.kitti"); });
    attempt([&] {
      write_run_plot(folder / "trajectory.svg", source_->info(), outputs_, config_, scale_.step_length->metric());
    });
    attempt([&] { write_whole_file(folder / "report.json", report(summary).dump(2) + "\n"); });
  }

  void check_something_came(const Counts& counts) const {
    if (counts.in == 0) throw std::runtime_error(call_.source + ": not one frame came from it");
    if (counts.done == 0)
      throw std::runtime_error(call_.source +
                               ": not one frame could be processed; the first failure: " + outputs_.first_failure());
  }

  const RunCall& call_;
  const Config& config_;
  SteadyClock clock_;
  std::unique_ptr<RunSource> source_;
  Camera camera_;
  Scale scale_;
  OdometryPipeline odometry_;
  std::unique_ptr<Movie> movie_;
  RunPublishing publishing_;
  std::unique_ptr<Trace> trace_;
  std::unique_ptr<MetricsFile> metrics_;
  std::chrono::steady_clock::time_point start_;
  RunOutputs outputs_;
  std::exception_ptr ended_by_;
  double wall_s_ = 0;
};

int run(const RunCall& call) {
  check_places(call);
  const Config config = resolved_config(call);
  // Signals are taken before any thread is made; the run that they stop may not exist yet.
  std::atomic<Pipeline<Frame>*> running{nullptr};
  std::atomic<bool> interrupted{false};
  const Signals signals([&] {
    interrupted = true;
    if (Pipeline<Frame>* pipeline = running.load()) pipeline->stop();
  });
  Run run(call, config);
  running = &run.engine();
  if (interrupted) run.engine().stop();
  run.drive();
  running = nullptr;
  return run.conclude(interrupted);
}

// An option that sets a key of the config.
void bind(CLI::App& command, RunCall& call, const std::string& option, const std::string& key, const std::string& help,
          const std::string& type) {
  command
      .add_option_function<std::string>(
          option,
          [&call, option, key](const std::string& v) {
            call.overrides.push_back({option, key, v});
          },
          help)
      ->type_name(type);
}

void bind_flag(CLI::App& command, RunCall& call, const std::string& option, const std::string& key,
               const std::string& value, const std::string& help) {
  command.add_flag_callback(
      option,
      [&call, option, key, value] {
        call.overrides.push_back({option, key, value});
      },
      help);
}

}  // namespace

void register_run(CLI::App& app, int& status) {
  auto call = std::make_shared<RunCall>();
  CLI::App& command = *app.add_subcommand("run", "Turn a source's frames into a trajectory");
  command.footer("Example: pavo run kitti/05 --out out/ --scale groundtruth --compare");
  command
      .add_option(
          "SOURCE", call->source,
          "a folder (KITTI odometry, KITTI raw, EuRoC, TUM RGB-D, images), a video file, a camera's node such as "
          "/dev/video0, or `synthetic`")
      ->required();
  command.add_option("--out", call->out, "folder for trajectory, picture, tables and report")->type_name("DIR");
  command.add_option("--config", call->config_file, "settings, see docs/configuration.md")->type_name("FILE.toml");
  command.add_option("--draw", call->draw, "the inside of every frame, as pictures or a film")
      ->type_name("DIR|FILE.mp4");
  command.add_option("--trace", call->trace, "what every thread did when, for ui.perfetto.dev")->type_name("FILE.json");
  command.add_option("--metrics", call->metrics, "counts and latencies, a line a second")->type_name("FILE.jsonl");
  bind(command, *call, "--calibration", "source.calibration", "the camera; default: the source's own", "FILE");
  bind(command, *call, "--groundtruth", "source.groundtruth", "for plot and report; default: the source's own",
       "FILE|none");
  bind(command, *call, "--rate", "source.rate_hz", "gives times to a source without any", "HZ");
  CLI::App* modes = &command;
  bind_flag(*modes, *call, "--live", "source.mode", "live", "take the newest frame, drop what is late");
  bind_flag(*modes, *call, "--every-frame", "source.mode", "every-frame", "take every frame (default but for devices)");
  command.get_option("--live")->excludes("--every-frame");
  bind(command, *call, "--estimator", "odometry.estimator", "auto, keyframe or frame-to-frame", "NAME");
  bind(command, *call, "--tracker", "odometry.tracker", "descriptor or klt", "NAME");
  bind(command, *call, "--scale", "odometry.scale",
       "unit, camera-height[=M], speed=FILE|-|unix:PATH or groundtruth[=FILE]", "SCALE");
  bind(command, *call, "--camera-height", "camera.height_m", "of the camera above the ground", "METRES");
  bind(command, *call, "--publish", "output.publish", "-, unix:PATH or udp:HOST:PORT: each pose as a line of JSON",
       "WHERE");
  bind(command, *call, "--seed", "odometry.seed", "of the run's random numbers", "N");
  bind(command, *call, "--workers", "engine.workers", "threads that run stages; default: one a core", "N");
  bind(command, *call, "--simd", "engine.simd", "SIMD target, such as AVX2; default: the best", "TARGET");
  bind(command, *call, "--alpha", "undistort.alpha", "0 keeps K, 1 widens the view to all pixels", "0..1");
  bind(command, *call, "--model", "people.model", "pedestrian classifier; default: the built-in one", "FILE");
  bind_flag(command, *call, "--no-people", "people.enabled", "false", "leave finding and removing people out");
  bind_flag(command, *call, "--compare", "odometry.compare", "true", "estimate once more without removing people");
  call->given = [&command](const std::string& option) { return command.count(option) > 0; };
  command.callback([call, &status] { status = run(*call); });
}

}  // namespace pavo
