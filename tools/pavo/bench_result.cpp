#include "tools/pavo/bench_result.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace pavo {
namespace {

using Json = nlohmann::ordered_json;

Json quantiles(const Quantiles& q) {
  return {{"p50", q.p50}, {"p90", q.p90}, {"p99", q.p99}, {"p999", q.p999}, {"max", q.max}};
}

Json run_json(const BenchRun& run) {
  Json stages = Json::object();
  for (const StageFigures& s : run.stages)
    stages[s.name] = {
        {"wait_ms", quantiles(s.wait_ms)}, {"service_ms", quantiles(s.service_ms)}, {"cpu_ms", quantiles(s.cpu_ms)}};
  return {{"load_percent", run.load_percent},
          {"offered_fps", run.offered_fps},
          {"done_fps", run.done_fps},
          {"dropped", run.dropped},
          {"end_to_end_ms", quantiles(run.end_to_end_ms)},
          {"age_ms", quantiles(run.age_ms)},
          {"stages", stages}};
}

Json machine_json(const BenchResult& result) {
  const Machine& m = result.machine;
  return {{"cpu", m.cpu},
          {"cores", m.cores},
          {"governor", m.governor},
          {"kernel", m.kernel},
          {"simd", m.simd},
          {"compiler", m.compiler},
          {"used_by_others_percent", result.others.percent},
          {"stolen_percent", result.others.stolen_percent}};
}

// A few hundred points tell the eye as much as all of them: the oldest of each stretch of time.
Json over_time(const BenchedLoad& load) {
  constexpr std::size_t kPoints = 400;
  Json t = Json::array(), age = Json::array();
  const std::size_t stretch = std::max<std::size_t>(1, load.samples.size() / kPoints);
  for (std::size_t i = 0; i + stretch <= load.samples.size(); i += stretch) {
    const auto from = load.samples.begin() + static_cast<std::ptrdiff_t>(i);
    const auto oldest = std::max_element(from, from + static_cast<std::ptrdiff_t>(stretch),
                                         [](const auto& a, const auto& b) { return a.age_ms < b.age_ms; });
    t.push_back(oldest->t_s);
    age.push_back(oldest->age_ms);
  }
  return {{"load_percent", load.median.load_percent}, {"t_s", t}, {"age_ms", age}};
}

using Out = std::back_insert_iterator<std::string>;

void row(Out out, const std::string& name, const Quantiles& q, const std::string& more = "") {
  fmt::format_to(out, "    {:<22}{:>9.2f}{:>9.2f}{:>9.2f}{:>9.2f}{:>9.2f}{}\n", name, q.p50, q.p90, q.p99, q.p999,
                 q.max, more);
}

void load_text(Out out, const BenchedLoad& load) {
  const BenchRun& run = load.median;
  const auto p99 = spread_of(load.repeats, [](const BenchRun& r) { return r.end_to_end_ms.p99; });
  fmt::format_to(out, "\nload {:.0f} %: {:.2f} frames a second offered, {:.2f} done, {} dropped\n", run.load_percent,
                 run.offered_fps, run.done_fps, run.dropped);
  fmt::format_to(out, "    {:<22}{:>9}{:>9}{:>9}{:>9}{:>9}\n", "ms", "p50", "p90", "p99", "p99.9", "max");
  row(out, "end to end", run.end_to_end_ms,
      load.repeats.size() > 1
          ? fmt::format("   p99 {:.2f} to {:.2f} in {} runs", p99.least, p99.most, load.repeats.size())
          : "");
  row(out, "age", run.age_ms);
  for (const StageFigures& stage : run.stages) {
    row(out, stage.name + " wait", stage.wait_ms);
    row(out, stage.name + " service", stage.service_ms);
    row(out, stage.name + " cpu", stage.cpu_ms);
  }
}

}  // namespace

nlohmann::ordered_json bench_json(const BenchResult& result, const nlohmann::ordered_json& config) {
  Json json;
  json["machine"] = machine_json(result);
  json["capacity_fps"] = result.capacity_fps;
  json["runs"] = Json::array();
  for (const BenchedLoad& load : result.loads) json["runs"].push_back(run_json(load.median));
  json["repeats"] = Json::array();
  for (const BenchedLoad& load : result.loads)
    for (const BenchRun& run : load.repeats) json["repeats"].push_back(run_json(run));
  json["capacities_fps"] = result.capacities_fps;
  json["over_time"] = Json::array();
  for (const BenchedLoad& load : result.loads) json["over_time"].push_back(over_time(load));
  json["source"] = {
      {"path", result.source}, {"frames", result.frames}, {"width", result.width}, {"height", result.height}};
  json["mode"] = result.mode;
  json["workers"] = result.workers;
  json["seconds"] = result.seconds;
  json["warnings"] = result.warnings;
  json["pavo"] = result.machine.version;
  json["config"] = config;
  return json;
}

std::string bench_text(const BenchResult& result) {
  std::string text;
  const Out out = std::back_inserter(text);
  const Machine& m = result.machine;
  fmt::format_to(out, "{}: {} frames of {}x{} in memory, as the source delivers them; {}, {} workers\n", result.source,
                 result.frames, result.width, result.height, result.mode, result.workers);
  fmt::format_to(out, "{}, {} cores, governor {}, {}, {}; others used {:.0f} % of it\n", m.cpu, m.cores, m.governor,
                 m.kernel, m.simd, result.others.percent);
  const auto [least, most] = std::minmax_element(result.capacities_fps.begin(), result.capacities_fps.end());
  fmt::format_to(out, "capacity: {:.2f} frames a second", result.capacity_fps);
  if (result.capacities_fps.size() > 1)
    fmt::format_to(out, " ({:.2f} to {:.2f} in {} runs)", *least, *most, result.capacities_fps.size());
  fmt::format_to(out, "\n");
  for (const BenchedLoad& load : result.loads) load_text(out, load);
  return text;
}

}  // namespace pavo
