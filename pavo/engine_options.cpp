#include "pavo/engine_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace pavo {
namespace {

std::int64_t nanoseconds(double value, double unit_ns) {
  return static_cast<std::int64_t>(std::llround(value * unit_ns));
}

std::optional<std::vector<int>> numbers(std::string_view text) {
  std::vector<int> result;
  for (const char *at = text.data(), *end = at + text.size();;) {
    int number = 0;
    const auto [behind, error] = std::from_chars(at, end, number);
    if (error != std::errc()) return std::nullopt;
    result.push_back(number);
    if (behind == end) return result;
    if (*behind != ',') return std::nullopt;
    at = behind + 1;
  }
}

}  // namespace

std::vector<PipelineOptions::Affinity> parse_affinity(const std::string& text) {
  std::vector<PipelineOptions::Affinity> result;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const std::size_t equals = word.find('=');
    const auto workers = equals == std::string::npos ? std::nullopt : numbers(word.substr(equals + 1));
    if (equals == 0 || !workers)
      throw std::runtime_error(
          "engine.affinity must be stages with their workers, as in \"odometry=0 scan=0,1\", not '" + word + "'");
    result.push_back({word.substr(0, equals), *workers});
  }
  return result;
}

std::vector<int> parse_cpus(const std::string& text) {
  if (text.empty()) return {};
  if (auto cpus = numbers(text)) return *cpus;
  throw std::runtime_error("engine.cpus must be numbers of cpus, as in \"0,1\", not '" + text + "'");
}

PipelineOptions engine_options(const Config& config) {
  const Config::EngineSettings& engine = config.engine;
  PipelineOptions options;
  options.workers =
      engine.workers > 0 ? engine.workers : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  options.slots = engine.slots;
  // One more would only wait: idle workers help with the scan of the frames that are there. Measured: 0.76 of the age
  // at 0.94 of the frames.
  options.live_credits = engine.live_credits > 0 ? engine.live_credits : std::max(2, options.workers);
  options.failures_in_a_row = engine.failures_in_a_row;
  options.admission = config.source.mode == "live" ? Admission::live : Admission::every_frame;
  options.stage_limit_ns = nanoseconds(engine.stage_limit_s, 1e9);
  options.source_limit_ns = nanoseconds(engine.source_limit_s, 1e9);
  options.latency_budget_ns = nanoseconds(engine.latency_budget_ms, 1e6);
  options.background_nice = engine.background_nice;
  options.affinity = parse_affinity(engine.affinity);
  options.cpus = parse_cpus(engine.cpus);
  options.fifo_priority = engine.fifo_priority;
  options.lock_memory = engine.lock_memory;
  return options;
}

}  // namespace pavo
