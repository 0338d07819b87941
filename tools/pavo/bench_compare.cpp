#include "tools/pavo/bench_compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <vector>

#include "drivers/trajectories/append_file.h"

namespace pavo {
namespace {

constexpr double kLeastChange = 0.02, kLeastChangeOfOne = 0.10;  // of what it was
constexpr double kLeastChange_ms = 0.02;                         // what a wake-up more or less is worth

// One figure: its median and how far its repeats lay apart.
struct Figure {
  double median = 0, spread = 0;
  bool repeated = false;
};

struct Tally {
  std::string text;
  int beyond = 0, within = 0;

  void compare(const std::string& what, const char* unit, const std::optional<Figure>& before,
               const std::optional<Figure>& now, bool more_is_better) {
    if (!before || !now || before->median <= 0) return;
    const bool repeated = before->repeated && now->repeated;
    const double change = now->median - before->median;
    const double share = (repeated ? kLeastChange : kLeastChangeOfOne) * before->median;
    const double least = more_is_better ? share : std::max(share, kLeastChange_ms);
    if (std::abs(change) <= std::max(before->spread + now->spread, least)) {
      ++within;
      return;
    }
    ++beyond;
    fmt::format_to(std::back_inserter(text), "  {:<38} {:>9.2f} -> {:>9.2f} {} ({:+.1f} %, {})\n", what, before->median,
                   now->median, unit, 100 * change / before->median,
                   (change > 0) == more_is_better ? "better" : "worse");
  }
};

// The same share of its own capacity, or the same rate.
bool same_load(const nlohmann::json& a, const nlohmann::json& b) {
  const auto apart = [&](const char* key) { return std::abs(a.at(key).get<double>() - b.at(key).get<double>()); };
  return apart("load_percent") < 0.5 || apart("offered_fps") < 1e-3 * b.at("offered_fps").get<double>();
}

std::optional<Figure> figure(const std::vector<double>& values, double median) {
  if (values.empty()) return Figure{median, 0, false};
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  return Figure{median, *most - *least, values.size() > 1};
}

// The figure at a place ("end_to_end_ms/p99") of one load's run; nothing where it is not there.
std::optional<Figure> figure_at(const nlohmann::json& bench, const nlohmann::json& run, const std::string& place) {
  const nlohmann::json::json_pointer pointer("/" + place);
  if (!run.contains(pointer) || !run.at(pointer).is_number()) return std::nullopt;
  std::vector<double> values;
  if (bench.contains("repeats"))
    for (const nlohmann::json& repeat : bench.at("repeats"))
      if (same_load(repeat, run) && repeat.contains(pointer) && repeat.at(pointer).is_number())
        values.push_back(repeat.at(pointer).get<double>());
  return figure(values, run.at(pointer).get<double>());
}

std::optional<Figure> capacity(const nlohmann::json& bench) {
  std::vector<double> values;
  if (bench.contains("capacities_fps")) values = bench.at("capacities_fps").get<std::vector<double>>();
  return figure(values, bench.at("capacity_fps").get<double>());
}

// "/" in a stage's name would be a level of the tree.
std::string escaped(std::string name) {
  for (std::size_t at = 0; (at = name.find_first_of("~/", at)) != std::string::npos; at += 2)
    name.replace(at, 1, name[at] == '~' ? "~0" : "~1");
  return name;
}

void compare_run(Tally& tally, const nlohmann::json& before, const nlohmann::json& then, const nlohmann::json& after,
                 const nlohmann::json& now) {
  const std::string load = fmt::format("at {:.0f} %: ", now.at("load_percent").get<double>());
  const auto both = [&](const std::string& what, const char* unit, const std::string& place, bool more_is_better) {
    tally.compare(load + what, unit, figure_at(before, then, place), figure_at(after, now, place), more_is_better);
  };
  // Below the capacity, what comes out is what was offered.
  if (now.at("load_percent").get<double>() >= 100) both("done", "frames/s", "done_fps", true);
  for (const char* q : {"p50", "p90", "p99", "p999", "max"}) {
    both(std::string("end to end ") + q, "ms", std::string("end_to_end_ms/") + q, false);
    both(std::string("age ") + q, "ms", std::string("age_ms/") + q, false);
  }
  if (!now.contains("stages")) return;
  for (const auto& [stage, figures] : now.at("stages").items())
    for (const char* what : {"wait", "service", "cpu"})
      for (const char* q : {"p50", "p99"})
        both(stage + " " + what + " " + q, "ms", fmt::format("stages/{}/{}_ms/{}", escaped(stage), what, q), false);
}

void note_differences(std::string& text, const nlohmann::json& before, const nlohmann::json& now) {
  for (const char* place : {"/machine/cpu", "/machine/cores", "/machine/governor", "/machine/kernel", "/machine/simd",
                            "/source/path", "/mode", "/workers"}) {
    const nlohmann::json::json_pointer pointer(place);
    if (before.contains(pointer) && now.contains(pointer) && before.at(pointer) != now.at(pointer))
      fmt::format_to(std::back_inserter(text), "  not measured alike: {} was {}, is {}\n", place + 1,
                     before.at(pointer).dump(), now.at(pointer).dump());
  }
}

bool is_quantiles(const nlohmann::json& json) {
  return json.is_object() &&
         std::all_of(json.begin(), json.end(), [](const nlohmann::json& v) { return v.is_number(); });
}

bool is_run(const nlohmann::json& json) {
  if (!json.is_object()) return false;
  for (const char* number : {"load_percent", "offered_fps", "done_fps"})
    if (!json.contains(number) || !json.at(number).is_number()) return false;
  for (const char* latency : {"end_to_end_ms", "age_ms"})
    if (!json.contains(latency) || !is_quantiles(json.at(latency))) return false;
  return !json.contains("stages") || json.at("stages").is_object();
}

bool are_runs(const nlohmann::json& json) {
  return json.is_array() && std::all_of(json.begin(), json.end(), is_run);
}

bool is_bench(const nlohmann::json& json) {
  if (!json.is_object() || !json.contains("capacity_fps") || !json.at("capacity_fps").is_number()) return false;
  if (!json.contains("runs") || !are_runs(json.at("runs"))) return false;
  if (json.contains("repeats") && !are_runs(json.at("repeats"))) return false;
  if (!json.contains("capacities_fps")) return true;
  const nlohmann::json& all = json.at("capacities_fps");
  return all.is_array() && std::all_of(all.begin(), all.end(), [](const nlohmann::json& v) { return v.is_number(); });
}

}  // namespace

nlohmann::json read_bench_json(const std::string& path) {
  constexpr std::size_t kLimit = std::size_t{64} << 20;
  const nlohmann::json json = nlohmann::json::parse(read_whole_file(path, kLimit), nullptr, false);
  if (json.is_discarded())
    throw std::runtime_error(path + ": this is no JSON; expected what `pavo bench --json` wrote");
  if (!is_bench(json))
    throw std::runtime_error(path +
                             ": this is no result of a benchmark (capacity_fps, runs); expected what `pavo bench "
                             "--json` wrote");
  return json;
}

std::string compare_benches(const nlohmann::json& before, const std::string& name, const nlohmann::json& now) {
  Tally tally;
  tally.compare("capacity", "frames/s", capacity(before), capacity(now), true);
  int loads = 0;
  for (const nlohmann::json& run : now.at("runs"))
    for (const nlohmann::json& then : before.at("runs"))
      if (same_load(run, then)) {
        compare_run(tally, before, then, now, run);
        ++loads;
        break;
      }
  std::string text = fmt::format("\nagainst {} ({} loads in both):\n", name, loads);
  note_differences(text, before, now);
  text += tally.text;
  return text + fmt::format("  {} figures are within noise, {} beyond it\n", tally.within, tally.beyond);
}

}  // namespace pavo
