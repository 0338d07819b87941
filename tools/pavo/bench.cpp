#include "tools/pavo/bench.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "drivers/trajectories/append_file.h"
#include "pavo/config.h"
#include "pavo/simd.h"
#include "tools/pavo/bench_compare.h"
#include "tools/pavo/bench_plot.h"
#include "tools/pavo/bench_result.h"
#include "tools/pavo/open_source.h"
#include "tools/pavo/progress.h"
#include "tools/pavo/usage_error.h"

namespace pavo {
namespace {

struct BenchCall {
  std::string source = "synthetic";
  std::string config_file, json, plot, against;
  std::optional<double> rate_hz;
  std::vector<double> loads{50, 80, 100, 120};
  double seconds = 3;
  int repeats = 3, frames = 100;
  bool every_frame = false;
  std::vector<std::pair<std::string, std::string>> overrides;  ///< key of the config, value
  std::vector<std::string> options;                            ///< their options, for messages
};

constexpr double kMostLoad_percent = 1000;

template <class T>
void check_range(const char* option, T value, double least, double most) {
  const auto v = static_cast<double>(value);
  if (!(std::isfinite(v) && v >= least && v <= most))
    throw UsageError(fmt::format("{} must be from {} to {}, not {}", option, least, most, value));
}

void check_output(const char* option, const std::string& path) {
  namespace fs = std::filesystem;
  if (path.empty()) return;
  std::error_code error;
  if (fs::is_directory(path, error))
    throw UsageError(fmt::format("{} {}: this is a folder, expected a file", option, path));
  const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error))
    throw std::runtime_error(fmt::format("{} {}: there is no folder {}; make it first", option, path, folder.string()));
  if (!fs::exists(path, error) && ::access(folder.c_str(), W_OK) != 0)
    throw std::runtime_error(fmt::format("{} {}: the folder cannot be written to", option, path));
}

// All that can be known to be wrong before a minute of measuring.
void check(const BenchCall& call) {
  if (call.source.empty()) throw UsageError("SOURCE is empty: expected a folder, a video file, or `synthetic`");
  for (const double load : call.loads) check_range("--load", load, 0.1, kMostLoad_percent);
  if (call.rate_hz) check_range("--rate", *call.rate_hz, 0.01, 100000);
  check_range("--seconds", call.seconds, 0.05, 86400);
  check_range("--repeat", call.repeats, 1, 1000);
  check_range("--frames", call.frames, 2, 100000);
  check_output("--json", call.json);
  check_output("--plot", call.plot);
}

Config config_of(const BenchCall& call) {
  Config config;
  if (!call.config_file.empty()) read_config(call.config_file, config);
  try {
    for (std::size_t i = 0; i < call.overrides.size(); ++i)
      set_from_text(config, call.overrides[i].first, call.overrides[i].second, call.options[i]);
    settle_camera_height(config);
    check_estimator(config);
    force_simd(config.engine.simd);
  } catch (const std::exception& e) {
    throw UsageError(e.what());
  }
  config.source.mode = call.every_frame ? "every-frame" : "live";
  config.source.groundtruth = "none";
  if (config.engine.workers == 0) config.engine.workers = this_machine().cores;
  return config;
}

// Measures capacity and loads in turn, as often as asked, so that what the machine does meanwhile meets all alike.
class Bench {
 public:
  Bench(const BenchCall& call, const Config& config) : call_(call), config_(config) {
    const std::unique_ptr<Sequence> sequence = open_source(call.source, config);
    const SequenceInfo& info = sequence->info();
    if (!info.camera)
      throw std::runtime_error(info.path + ": no calibration was found for it; give one with --calibration FILE");
    camera_ = *info.camera;
    frames_.emplace(*sequence, call.frames);
  }

  BenchResult measure() {
    BenchResult result = described();
    const OtherWork work;
    measure_capacity(result);
    for (int repeat = 0; repeat < call_.repeats; ++repeat)
      for (BenchedLoad& load : result.loads) measure_once(load);
    for (BenchedLoad& load : result.loads) load.median = median_of(load.repeats);
    result.others = work.others();
    warn(result);
    return result;
  }

  int runs() const { return call_.repeats * (1 + static_cast<int>(call_.rate_hz ? 1 : call_.loads.size())); }
  std::int64_t runs_done() const { return runs_done_.load(); }

 private:
  BenchResult described() const {
    return {.machine = this_machine(),
            .source = call_.source,
            .mode = config_.source.mode,
            .frames = static_cast<int>(frames_->size()),
            .width = camera_.width,
            .height = camera_.height,
            .workers = config_.engine.workers,
            .seconds = call_.seconds};
  }

  BenchRun run(const BenchLoad& load, std::vector<BenchSample>& samples) {
    try {
      BenchRun one = bench_run(config_, camera_, *frames_, load, samples);
      ++runs_done_;
      return one;
    } catch (const std::exception& e) {
      throw std::runtime_error(call_.source + ": " + e.what());
    }
  }

  void measure_capacity(BenchResult& result) {
    std::vector<BenchRun> full_speed;
    std::vector<BenchSample> unused;
    for (int repeat = 0; repeat < call_.repeats; ++repeat) {
      full_speed.push_back(run({.rate_hz = 0, .seconds = call_.seconds}, unused));
      result.capacities_fps.push_back(full_speed.back().done_fps);
    }
    result.full_speed = median_of(full_speed);
    result.capacity_fps = result.full_speed.done_fps;
    if (call_.rate_hz) {
      result.loads.push_back(
          {.median = {.load_percent = 100 * *call_.rate_hz / result.capacity_fps, .offered_fps = *call_.rate_hz}});
      return;
    }
    for (const double percent : call_.loads)
      result.loads.push_back({.median = {.load_percent = percent, .offered_fps = result.capacity_fps * percent / 100}});
  }

  void measure_once(BenchedLoad& load) {
    std::vector<BenchSample> samples;
    BenchRun one = run({.rate_hz = load.median.offered_fps, .seconds = call_.seconds}, samples);
    one.load_percent = load.median.load_percent;
    for (const BenchSample& sample : samples) load.all_ms.push_back(sample.age_ms);
    if (load.repeats.empty()) load.samples = std::move(samples);
    load.repeats.push_back(std::move(one));
  }

  static void warn(BenchResult& result) {
    constexpr double kBusy_percent = 5, kStolen_percent = 1;
    if (result.others.percent > kBusy_percent)
      result.warnings.push_back(
          fmt::format("other programs used {:.0f} % of this machine meanwhile: the figures are "
                      "worse than they could be, and will not repeat",
                      result.others.percent));
    if (result.others.stolen_percent > kStolen_percent)
      result.warnings.push_back(
          fmt::format("other virtual machines took {:.0f} % of this one's time", result.others.stolen_percent));
    if (result.machine.governor != "none" && result.machine.governor != "performance")
      result.warnings.push_back("the frequency governor is '" + result.machine.governor +
                                "': with 'performance' the figures repeat better");
  }

  const BenchCall& call_;
  const Config& config_;
  Camera camera_;
  std::optional<BenchFrames> frames_;
  std::atomic<std::int64_t> runs_done_{0};
};

int bench(const BenchCall& call) {
  check(call);
  const Config config = config_of(call);
  std::optional<nlohmann::json> before;
  if (!call.against.empty()) before = read_bench_json(call.against);
  Bench bench(call, config);
  const BenchResult result = [&] {
    const Progress progress("bench, runs", bench.runs(), [&] { return bench.runs_done(); });
    return bench.measure();
  }();
  fmt::print("{}", bench_text(result));
  const nlohmann::ordered_json json = bench_json(result, to_json(config));
  if (before) fmt::print("{}", compare_benches(*before, call.against, nlohmann::json(json)));
  if (!call.json.empty()) write_whole_file(call.json, json.dump(2) + "\n");
  if (!call.plot.empty()) write_whole_file(call.plot, bench_svg(result));
  for (const std::string& warning : result.warnings) fmt::print(stderr, "pavo: warning: {}\n", warning);
  return 0;
}

void bind(CLI::App& command, BenchCall& call, const std::string& option, const std::string& key,
          const std::string& help, const std::string& type) {
  command
      .add_option_function<std::string>(
          option,
          [&call, option, key](const std::string& v) {
            call.overrides.emplace_back(key, v);
            call.options.push_back(option);
          },
          help)
      ->type_name(type);
}

// A file that is named by an empty word is a shell variable that was never set.
CLI::Option* add_file(CLI::App& command, const std::string& option, std::string& path, const std::string& help,
                      const std::string& type) {
  return command
      .add_option_function<std::string>(
          option,
          [&path, option](const std::string& v) {
            if (v.empty()) throw UsageError(option + " is empty: expected a file");
            path = v;
          },
          help)
      ->type_name(type);
}

}  // namespace

void register_bench(CLI::App& app, int& status) {
  auto call = std::make_shared<BenchCall>();
  CLI::App& command = *app.add_subcommand("bench", "Measure throughput, and latency under load, on this machine");
  command.footer(
      "Example: pavo bench kitti/05 --json now.json --against before.json\n"
      "Frames lie in memory and come at their intended times, whatever the pipeline does; latency counts from there.");
  command.add_option("SOURCE", call->source,
                     "what pavo run takes; its first frames are played forth and back (default: synthetic)");
  CLI::Option* rate = command.add_option("--rate", call->rate_hz, "offer so many frames a second")->type_name("HZ");
  command.add_option("--load", call->loads, "offer so much of the capacity (default: 50 80 100 120)")
      ->type_name("PERCENT...")
      ->excludes(rate);
  add_file(command, "--json", call->json, "write all figures", "FILE");
  add_file(command, "--plot", call->plot, "write the distributions and the age over time", "FILE.svg");
  add_file(command, "--against", call->against, "say what has changed beyond noise since then", "OLD.json");
  command.add_option("--seconds", call->seconds, "of each run behind its warm-up (default: 3)")->type_name("S");
  command.add_option("--repeat", call->repeats, "runs of each load (default: 3)")->type_name("N");
  command.add_option("--frames", call->frames, "to take into memory (default: 100)")->type_name("N");
  command.add_flag("--every-frame", call->every_frame,
                   "queue what comes too fast instead of dropping it: the age of data grows above the capacity");
  add_file(command, "--config", call->config_file, "settings, see docs/configuration.md", "FILE.toml");
  bind(command, *call, "--calibration", "source.calibration", "the camera; default: the source's own", "FILE");
  bind(command, *call, "--workers", "engine.workers", "threads that run stages; default: one a core", "N");
  bind(command, *call, "--simd", "engine.simd", "SIMD target, such as AVX2; default: the best", "TARGET");
  bind(command, *call, "--tracker", "odometry.tracker", "descriptor or klt", "NAME");
  command.add_flag_callback(
      "--no-people",
      [call] {
        call->overrides.emplace_back("people.enabled", "false");
        call->options.emplace_back("--no-people");
      },
      "leave finding and removing people out");
  command.callback([call, &status] { status = bench(*call); });
}

}  // namespace pavo
