// What does --trace cost? The real pipeline at full speed on frames in memory, with a trace and without, in turn;
// checked first: that nothing of the trace is lost, and every frame is in it. What counts is the ratio of each pair.
//
//     bench_trace [SOURCE] [ROUNDS] [SECONDS]          default: synthetic, 11 pairs, 2 seconds a run
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/pavo/bench_run.h"
#include "tools/pavo/open_source.h"

namespace pavo::bench {
namespace {

struct Figures {
  double fps = 0, cpu_ms = 0;  // a frame
};

double process_cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec) * 1e-9;
}

double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
}

class Pairs {
 public:
  Pairs(const std::string& source, double seconds)
      : sequence_(open_source(source, {})), frames_(*sequence_, 100), load_{.rate_hz = 0, .seconds = seconds} {
    if (!sequence_->info().camera) throw std::runtime_error(source + ": expected a source with a calibration");
  }

  Figures run(bool traced) {
    const std::string path = (std::filesystem::temp_directory_path() / "pavo-bench-trace.json").string();
    std::optional<Trace> trace;
    BenchLoad load = load_;
    if (traced) load.trace = &trace.emplace(path);
    std::vector<BenchSample> samples;
    const double before_s = process_cpu_s();
    const BenchRun result = bench_run(Config(), *sequence_->info().camera, frames_, load, samples);
    if (trace) trace->finish();
    const double cpu_s = process_cpu_s() - before_s;
    if (trace) check(*trace, path, samples.size());
    return {result.done_fps, cpu_s * 1e3 / static_cast<double>(samples.size())};
  }

 private:
  static void check(const Trace& trace, const std::string& path, std::size_t frames) {
    if (trace.lost() > 0) throw std::runtime_error("events of the trace were lost");
    std::size_t deliveries = 0;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);)
      deliveries += line.find("\"name\":\"delivery\"") != std::string::npos ? 1 : 0;
    std::filesystem::remove(path);
    if (deliveries < frames) throw std::runtime_error("frames are missing in the trace");
  }

  std::unique_ptr<Sequence> sequence_;
  BenchFrames frames_;
  BenchLoad load_;
};

void measure(const std::string& source, int rounds, double seconds) {
  Pairs pairs(source, seconds);
  std::vector<double> plain_fps, traced_fps, throughput, cpu;
  for (int round = 0; round < rounds; ++round) {
    const bool traced_first = round % 2 == 1;
    const Figures first = pairs.run(traced_first), second = pairs.run(!traced_first);
    const Figures &traced = traced_first ? first : second, &plain = traced_first ? second : first;
    plain_fps.push_back(plain.fps);
    traced_fps.push_back(traced.fps);
    throughput.push_back(100 * (1 - traced.fps / plain.fps));
    cpu.push_back(100 * (traced.cpu_ms / plain.cpu_ms - 1));
  }
  std::printf("| | frames/s | with --trace | throughput lost, %% | more CPU a frame, %% |\n");
  std::printf("| --- | --- | --- | --- | --- |\n");
  std::printf("| median of %d pairs (quartiles) | %.1f | %.1f | %.2f (%.2f to %.2f) | %.2f (%.2f to %.2f) |\n", rounds,
              quantile(plain_fps, 0.5), quantile(traced_fps, 0.5), quantile(throughput, 0.5),
              quantile(throughput, 0.25), quantile(throughput, 0.75), quantile(cpu, 0.5), quantile(cpu, 0.25),
              quantile(cpu, 0.75));
}

}  // namespace
}  // namespace pavo::bench

int main(int argc, char** argv) {
  try {
    pavo::bench::measure(argc > 1 ? argv[1] : "synthetic", argc > 2 ? std::max(1, std::atoi(argv[2])) : 11,
                         argc > 3 ? std::max(0.5, std::atof(argv[3])) : 2);
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "bench_trace: %s\n", e.what());
    return 1;
  }
}
