#include "tools/pavo/report.h"

#include <tbb/version.h>

#include <opencv2/core/version.hpp>

#include "pavo/simd.h"

namespace pavo {
namespace {

using Json = nlohmann::ordered_json;

Json stages(const Runtime& runtime) {
  Json json = Json::object();
  for (std::size_t n = 1; n < runtime.graph().delivery(); ++n) {
    const StageMetrics& m = runtime.stage_metrics(n);
    Json& stage = json[runtime.graph().nodes[n].name];
    stage = {{"wait_ms", quantiles_json(m.wait)},
             {"service_ms", quantiles_json(m.service)},
             {"cpu_ms", quantiles_json(m.cpu)}};
    add_counts(stage, m);
  }
  return json;
}

Json accuracy(const Evaluation& e) {
  Json json = {{"ate_sim3_m", e.sim3.ate_m.rmse},       {"ate_se3_m", e.se3.ate_m.rmse},
               {"sim3_scale", e.sim3.similarity.scale}, {"truth_length_m", e.truth_length_m},
               {"length_m", e.estimate_length_m},       {"rpe_translation_m", e.raw.rpe.translation_m.rmse}};
  const std::optional<SegmentErrors>& all = e.raw.segments.all;
  json["segments"] = all ? all->segments : 0;
  json["t_rel_percent"] = all ? Json(all->t_rel_percent) : Json(nullptr);
  json["r_rel_deg_per_100m"] = all ? Json(all->r_rel_deg_per_100m) : Json(nullptr);
  return json;
}

}  // namespace

Json quantiles_json(const Histogram& histogram) {
  return quantiles_json(histogram.quantiles_ms());
}

Json quantiles_json(const Quantiles& q) {
  return {{"p50", q.p50}, {"p90", q.p90}, {"p99", q.p99}, {"p999", q.p999}, {"max", q.max}};
}

Json frames_json(const Counts& counts, const Runtime& runtime) {
  Json dropped_by = Json::object(), failed_by = Json::object();
  for (std::size_t r = 0; r < kDropReasons.size(); ++r) dropped_by[std::string(kDropReasons[r])] = counts.dropped_by[r];
  for (std::size_t n = 0; n < runtime.graph().delivery(); ++n)
    if (const std::uint64_t failed = runtime.stage_metrics(n).failed.load(); failed > 0)
      failed_by[runtime.graph().nodes[n].name] = failed;
  return {{"in", counts.in},          {"done", counts.done},           {"dropped", counts.dropped},
          {"failed", counts.failed},  {"in_flight", counts.in_flight}, {"lost_before", counts.lost_before},
          {"dropped_by", dropped_by}, {"failed_by", failed_by}};
}

Json ring_json(const Runtime& runtime, const Quantiles& in_flight_ms) {
  constexpr double kOne = 1e6;  // the histogram's unit, as a count
  return {{"slots", runtime.slots()},
          {"in_flight",
           {{"p50", in_flight_ms.p50 * kOne}, {"p99", in_flight_ms.p99 * kOne}, {"max", in_flight_ms.max * kOne}}}};
}

void add_counts(Json& stage, const StageMetrics& metrics) {
  stage["failed"] = metrics.failed.load();
  if (const std::uint64_t late = metrics.late.load(); late > 0) stage["late"] = late;
  if (const std::uint64_t skipped = metrics.skipped.load(); skipped > 0) stage["skipped"] = skipped;
}

nlohmann::ordered_json report(const RunSummary& run) {
  const Counts counts = run.runtime.counts();
  const PoseCounts& poses = run.outputs.poses();
  const PeopleCounts& people = run.outputs.people();
  Json json;
  json["source"] = {
      {"path", run.source}, {"layout", run.layout}, {"calibration", run.calibration}, {"groundtruth", run.groundtruth}};
  json["frames"] = frames_json(counts, run.runtime);
  if (!run.camera.is_null()) json["camera"] = run.camera;
  json["wall_s"] = run.wall_s;
  json["fps"] = run.wall_s > 0 ? static_cast<double>(counts.done + counts.failed) / run.wall_s : 0.0;
  json["latency_ms"] = {{"end_to_end", quantiles_json(run.runtime.run_metrics().end_to_end)},
                        {"age", quantiles_json(run.runtime.run_metrics().age)},
                        {"jitter", quantiles_json(run.runtime.run_metrics().jitter)}};
  json["ring"] = ring_json(run.runtime, run.runtime.run_metrics().in_flight.quantiles_ms());
  json["stages"] = stages(run.runtime);
  json["estimator"] = uses_keyframes(run.config) ? "keyframe" : "frame-to-frame";
  json["tracker"] = run.config.odometry.tracker;
  json["scale"] = run.scale;
  json["simd"] = simd_target();
  json["poses"] = {{"tracked", poses.tracked},
                   {"standing", poses.standing},
                   {"coasting", poses.coasting},
                   {"relocalising", poses.relocalising}};
  json["people"] = {{"removed", run.config.people.enabled},
                    {"seen", people.seen},
                    {"features_dropped", people.features_dropped},
                    {"frames_with_too_few_features_left", people.frames_short}};
  if (run.evaluation) json["accuracy"] = accuracy(*run.evaluation);
  if (run.geometric_evaluation) json["accuracy_geometric"] = accuracy(*run.geometric_evaluation);
  if (!run.publishing.is_null()) json["publish"] = run.publishing;
  if (!run.speed.is_null()) json["speed"] = run.speed;
  json["not_drawn"] = run.not_drawn;
  json["trajectory_sha256"] = run.trajectory_sha256;
  json["warnings"] = run.warnings;
  json["versions"] = {
      {"pavo", PAVO_VERSION}, {"opencv", CV_VERSION}, {"tbb", TBB_VERSION_STRING}, {"compiler", __VERSION__}};
  json["config"] = to_json(run.config);
  return json;
}

}  // namespace pavo
