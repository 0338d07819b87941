#include "tools/pavo/metrics_file.h"

#include <fmt/format.h>
#include <pthread.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "tools/pavo/report.h"

namespace pavo {
namespace {

using Json = nlohmann::ordered_json;

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string in_words(const Counts& counts) {
  std::string words = fmt::format("{} dropped", counts.dropped);
  for (std::size_t r = 0, told = 0; r < kDropReasons.size(); ++r)
    if (counts.dropped_by[r] > 0)
      words += fmt::format("{}{} {}", told++ == 0 ? " (" : ", ", counts.dropped_by[r], kDropReasons[r]);
  return words + (counts.dropped > 0 ? ")" : "");
}

}  // namespace

RunLook::RunLook(const Runtime& runtime, TellCamera camera)
    : runtime_(runtime),
      camera_(std::move(camera)),
      end_to_end_(runtime.run_metrics().end_to_end),
      age_(runtime.run_metrics().age),
      jitter_(runtime.run_metrics().jitter),
      in_flight_(runtime.run_metrics().in_flight),
      t_begin_s_(now_s()),
      t_last_s_(t_begin_s_) {
  for (std::size_t n = 1; n < runtime.graph().delivery(); ++n) {
    const StageMetrics& m = runtime.stage_metrics(n);
    stages_.push_back({runtime.graph().nodes[n].name, &m, HistogramInterval(m.wait), HistogramInterval(m.service),
                       HistogramInterval(m.cpu)});
  }
}

double RunLook::step() {
  const double now = now_s();
  return now - std::exchange(t_last_s_, now);
}

double RunLook::rate(const Counts& counts, double seconds) {
  const std::uint64_t out = counts.done + counts.failed;
  const auto more = static_cast<double>(out - std::exchange(out_last_, out));
  return seconds > 0 ? more / seconds : 0;
}

Json RunLook::json() {
  const Counts counts = runtime_.counts();
  const double seconds = step();
  Json json = {
      {"t_s", t_last_s_ - t_begin_s_}, {"frames", frames_json(counts, runtime_)}, {"fps", rate(counts, seconds)}};
  if (Json camera = camera_(); !camera.is_null()) json["camera"] = std::move(camera);
  json["latency_ms"] = {{"end_to_end", quantiles_json(end_to_end_.look_ms())},
                        {"age", quantiles_json(age_.look_ms())},
                        {"jitter", quantiles_json(jitter_.look_ms())}};
  json["ring"] = ring_json(runtime_, in_flight_.look_ms());
  json["stages"] = Json::object();
  for (Stage& stage : stages_) {
    Json& at = json["stages"][stage.name];
    at = {{"wait_ms", quantiles_json(stage.wait.look_ms())},
          {"service_ms", quantiles_json(stage.service.look_ms())},
          {"cpu_ms", quantiles_json(stage.cpu.look_ms())}};
    add_counts(at, *stage.metrics);
  }
  return json;
}

std::string RunLook::line() {
  const Counts counts = runtime_.counts();
  const double seconds = step();
  const Quantiles age = age_.look_ms();
  const Json camera = camera_();
  const bool away = !camera.is_null() && camera["state"] == "away";
  return fmt::format("{:.1f} a second, age {:.0f} ms (p99 {:.0f}), {} in flight, {}, {} failed{}",
                     rate(counts, seconds), age.p50, age.p99, counts.in_flight, in_words(counts), counts.failed,
                     away ? "; the camera is away" : "");
}

MetricsFile::MetricsFile(const std::string& path, const Runtime& runtime, TellCamera camera)
    : file_(path), look_(runtime, std::move(camera)) {
  thread_ = std::jthread([this](const std::stop_token& stop) { write_until(stop); });
}

MetricsFile::~MetricsFile() {
  try {
    finish();
  } catch (const std::exception&) {  // who wants to know calls finish()
  }
}

void MetricsFile::finish() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
  write_line();
  if (!error_.empty()) throw std::runtime_error(error_);
  file_.close();
}

void MetricsFile::write_until(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "pavo-metrics");
  std::unique_lock lock(mutex_);
  while (!ended_.wait_for(lock, stop, std::chrono::seconds(1), [] { return false; }) && !stop.stop_requested())
    write_line();
}

// A full disk does not end the run: its other outputs may lie elsewhere. It is told at the end.
void MetricsFile::write_line() {
  if (!error_.empty()) return;
  try {
    file_.append(look_.json().dump() + "\n");
  } catch (const std::exception& e) {
    error_ = e.what();
  }
}

}  // namespace pavo
