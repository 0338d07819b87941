#include "tools/pavo/eval_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

namespace pavo {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array kAlignments{Alignment::none, Alignment::scale, Alignment::se3, Alignment::sim3};

/// Four significant digits, without an exponent as long as that can be read. Less than a nanometre is rounding.
std::string number(double value) {
  if (std::abs(value) < 1e-9) value = 0;
  std::array<char, 48> digits{};
  std::snprintf(digits.data(), digits.size(), std::abs(value) >= 1000 && std::abs(value) < 1e7 ? "%.0f" : "%#.4g",
                value);
  return digits.data();
}

std::string number(const std::optional<double>& value) {
  return value ? number(*value) : "-";
}

std::string right(const std::string& text, std::size_t width) {
  return std::string(width - std::min(width, text.size()), ' ') + text;
}
std::string left(const std::string& text, std::size_t width) {
  return text + std::string(width - std::min(width, text.size()), ' ');
}

/// A row of a table: its name, then cells of equal width.
template <typename... Cells>
std::string row(const std::string& name, const Cells&... cells) {
  return "  " + left(name, 24) + (right(cells, 11) + ...) + "\n";
}

std::string statistics_row(const std::string& name, const Statistics& s) {
  return row(name, number(s.rmse), number(s.mean), number(s.median), number(s.max));
}

std::optional<double> known_scale(const Similarity& similarity) {
  return similarity.scale_known ? std::optional(similarity.scale) : std::nullopt;
}

std::optional<double> t_rel(const std::optional<SegmentErrors>& errors) {
  return errors ? std::optional(errors->t_rel_percent) : std::nullopt;
}
std::optional<double> r_rel(const std::optional<SegmentErrors>& errors) {
  return errors ? std::optional(errors->r_rel_deg_per_100m) : std::nullopt;
}
std::string count(const std::optional<SegmentErrors>& errors) {
  return std::to_string(errors ? errors->segments : 0);
}

std::string ate_table(const Evaluation& e, Alignment chosen) {
  std::string text = row("ATE (m) aligned by", std::string("rmse"), std::string("mean"), std::string("median"),
                         std::string("max"), std::string("scale"));
  for (const Alignment alignment : kAlignments) {
    const AlignedErrors& a = e.aligned(alignment);
    text += row(std::string(alignment == chosen ? "* " : "  ") + alignment_name(alignment), number(a.ate_m.rmse),
                number(a.ate_m.mean), number(a.ate_m.median), number(a.ate_m.max), number(known_scale(a.similarity)));
  }
  return text;
}

std::string segment_table(const Evaluation& e, int step) {
  const auto line = [](const std::string& name, const std::optional<SegmentErrors>& raw,
                       const std::optional<SegmentErrors>& scaled) {
    return row(name, number(t_rel(raw)), number(t_rel(scaled)), number(r_rel(raw)), count(raw));
  };
  std::string text =
      row("KITTI, every " + std::to_string(step) +
              (step == 1   ? "st"
               : step == 2 ? "nd"
               : step == 3 ? "rd"
                           : "th") +
              " frame",
          std::string("t_rel %"), std::string("scaled %"), std::string("deg/100 m"), std::string("segments"));
  const SegmentErrorsByLength& raw = e.raw.segments;
  for (std::size_t i = 0; i < raw.lengths.size(); ++i) {
    if (!raw.lengths[i].errors) continue;
    text += line("  " + std::to_string(std::lround(raw.lengths[i].length_m)) + " m", raw.lengths[i].errors,
                 e.scaled ? e.scaled->segments.lengths[i].errors : std::nullopt);
  }
  return text + line("  all", raw.all, e.scaled ? e.scaled->segments.all : std::nullopt);
}

std::string rpe_table(const Evaluation& e) {
  std::string text =
      row("RPE per frame", std::string("rmse"), std::string("mean"), std::string("median"), std::string("max"));
  text += statistics_row("  translation (m)", e.raw.rpe.translation_m);
  if (e.scaled) text += statistics_row("  the same, scaled (m)", e.scaled->rpe.translation_m);
  return text + statistics_row("  rotation (deg)", e.raw.rpe.rotation_deg);
}

std::string parameter_table(const std::string& name, const ParameterRmse& raw, const ParameterRmse* scaled) {
  std::string text = row("RMSE of " + name, std::string("R"), std::string(""), std::string(""), std::string("t (m)"),
                         std::string("t scaled"));
  for (int i = 0; i < 3; ++i)
    text += row("", number(raw(i, 0)), number(raw(i, 1)), number(raw(i, 2)), number(raw(i, 3)),
                scaled ? number((*scaled)(i, 3)) : std::string("-"));
  return text;
}

std::string details(const EvaluatedFile& file, const EvalReport& report) {
  const Evaluation& e = file.evaluation;
  std::string text = file.path + " against " + report.truth_path + "\n";
  text += "  " + std::to_string(e.pairs) + " poses compared by " + (e.by_time ? "time" : "number") + " (of " +
          std::to_string(e.estimate_poses) + " and " + std::to_string(e.truth_poses) + "), " +
          number(e.estimate_length_m) + " m against " + number(e.truth_length_m) + " m\n\n";
  text += ate_table(e, report.alignment) + "\n" + segment_table(e, report.step) + "\n" + rpe_table(e) + "\n";
  text += parameter_table("the poses", e.raw.poses, e.scaled ? &e.scaled->poses : nullptr) + "\n";
  text += parameter_table("the motions", e.raw.motions, e.scaled ? &e.scaled->motions : nullptr) + "\n";
  if (e.scaled)
    return text + "  scaled: after one global scale, " + number(e.scaled->scale) + ", that of the Sim(3) alignment\n";
  return text + "  no scale: a path stands still\n";
}

std::string comparison(const EvalReport& report) {
  std::size_t width = 8;
  for (const EvaluatedFile& file : report.estimates) width = std::max(width, file.label.size());
  const auto line = [&](const std::string& name, const auto&... cells) {
    return "  " + left(name, width) + (right(cells, 11) + ...) + "\n";
  };
  std::string text = line("estimate", std::string("ATE m"), std::string("scale"), std::string("t_rel %"),
                          std::string("scaled %"), std::string("deg/100 m"), std::string("segments"));
  for (const EvaluatedFile& file : report.estimates) {
    const Evaluation& e = file.evaluation;
    const AlignedErrors& a = e.aligned(report.alignment);
    text += line(file.label, number(a.ate_m.rmse), number(known_scale(a.similarity)), number(t_rel(e.raw.segments.all)),
                 number(e.scaled ? t_rel(e.scaled->segments.all) : std::nullopt), number(r_rel(e.raw.segments.all)),
                 count(e.raw.segments.all));
  }
  return text + "  ATE: rmse, aligned by " + alignment_name(report.alignment) + "\n";
}

Json to_json(const Statistics& s) {
  return {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median}, {"max", s.max}};
}

Json to_json(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json to_json(const ParameterRmse& table) {
  Json rows = Json::array();
  for (int i = 0; i < 3; ++i) rows.push_back({table(i, 0), table(i, 1), table(i, 2), table(i, 3)});
  return rows;
}

Json to_json(const std::optional<SegmentErrors>& errors) {
  return {{"t_rel_percent", to_json(t_rel(errors))},
          {"r_rel_deg_per_100m", to_json(r_rel(errors))},
          {"segments", errors ? errors->segments : 0}};
}

Json to_json(const SegmentErrorsByLength& segments) {
  Json result = to_json(segments.all);
  result["lengths"] = Json::array();
  for (const auto& length : segments.lengths) {
    Json entry = to_json(length.errors);
    entry["length_m"] = length.length_m;
    result["lengths"].push_back(std::move(entry));
  }
  return result;
}

Json to_json(const ScaledErrors& errors) {
  return {{"scale", errors.scale},
          {"pose_rmse", to_json(errors.poses)},
          {"motion_rmse", to_json(errors.motions)},
          {"rpe",
           {{"translation_m", to_json(errors.rpe.translation_m)}, {"rotation_deg", to_json(errors.rpe.rotation_deg)}}},
          {"segments", to_json(errors.segments)}};
}

Json to_json(const EvaluatedFile& file) {
  const Evaluation& e = file.evaluation;
  Json ate = Json::object();
  for (const Alignment alignment : kAlignments) {
    const AlignedErrors& a = e.aligned(alignment);
    ate[alignment_key(alignment)] = to_json(a.ate_m);
    ate[alignment_key(alignment)]["scale"] = to_json(known_scale(a.similarity));
  }
  return {{"file", file.path},
          {"poses", e.estimate_poses},
          {"pairs", e.pairs},
          {"paired_by", e.by_time ? "time" : "number"},
          {"length_m", e.estimate_length_m},
          {"truth_length_m", e.truth_length_m},
          {"ate_m", ate},
          {"raw", to_json(e.raw)},
          {"scaled", e.scaled ? to_json(*e.scaled) : Json(nullptr)}};
}

}  // namespace

const char* alignment_name(Alignment alignment) {
  switch (alignment) {
    case Alignment::none:
      return "none";
    case Alignment::scale:
      return "scale";
    case Alignment::se3:
      return "SE(3)";
    case Alignment::sim3:
      return "Sim(3)";
  }
  throw std::invalid_argument("no such alignment");
}

const char* alignment_key(Alignment alignment) {
  switch (alignment) {
    case Alignment::none:
      return "none";
    case Alignment::scale:
      return "scale";
    case Alignment::se3:
      return "se3";
    case Alignment::sim3:
      return "sim3";
  }
  throw std::invalid_argument("no such alignment");
}

std::string eval_text(const EvalReport& report) {
  std::string text;
  for (const EvaluatedFile& file : report.estimates) text += (text.empty() ? "" : "\n") + details(file, report);
  if (report.estimates.size() > 1) text += "\n" + comparison(report);
  return text;
}

nlohmann::ordered_json eval_json(const EvalReport& report) {
  Json estimates = Json::array();
  for (const EvaluatedFile& file : report.estimates) estimates.push_back(to_json(file));
  return {{"groundtruth", {{"file", report.truth_path}, {"poses", report.truth_poses}}},
          {"step", report.step},
          {"align", alignment_key(report.alignment)},
          {"estimates", estimates}};
}

}  // namespace pavo
