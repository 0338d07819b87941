#include "tools/pavo/calibration_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "drivers/calibration/write_calibration.h"
#include "drivers/trajectories/svg_writer.h"
#include "stages/calibration/bundle.h"
#include "stages/calibration/coverage.h"
#include "types/lens.h"

namespace pavo {
namespace {

using Eigen::Vector2d;
using Json = nlohmann::ordered_json;

const char* name_of_parameter(Lens lens, int i) {
  static constexpr const char* kPinhole[] = {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"};
  static constexpr const char* kFisheye[] = {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"};
  return lens == Lens::equidistant ? kFisheye[i] : kPinhole[i];
}

const char* name_of_lens(Lens lens) {
  return lens == Lens::equidistant ? "equidistant" : "pinhole (radial-tangential)";
}

// JSON has no infinity.
Json finite(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

struct Parameter {
  const char* name;
  double value, sigma;
};

std::vector<Parameter> parameters_of(const CalibrationResult& result) {
  std::vector<Parameter> all;
  Camera camera = result.camera, sigma = result.sigma;
  for (int i = 0; i < parameter_count(camera.lens); ++i)
    all.push_back({name_of_parameter(camera.lens, i), parameter(camera, i), parameter(sigma, i)});
  return all;
}

std::vector<BoardCorners> used_views(const CalibrationReport& report) {
  std::vector<BoardCorners> used;
  for (std::size_t v = 0; v < report.views.size(); ++v)
    if (report.result.views[v].used) used.push_back(report.views[v]);
  return used;
}

std::vector<std::string> missing_of(const CalibrationReport& report) {
  const Camera& c = report.result.camera;
  return missing_views(coverage_of(used_views(report), report.board, c.width, c.height));
}

}  // namespace

std::string calibration_table(const CalibrationReport& report) {
  const CalibrationResult& r = report.result;
  std::string text = fmt::format("{} of {} views of {}x{}, lens {}\n", r.used, r.views.size(), r.camera.width,
                                 r.camera.height, name_of_lens(r.camera.lens));
  for (const Parameter& p : parameters_of(r))
    text += fmt::format("  {} {:12.6g} +- {:.2g}\n", p.name, p.value, p.sigma);
  text += fmt::format("  RMS {:.3f} px, on views kept out {:.3f} px; rows and columns straight to {:.3f} px (median)\n",
                      r.rms_px, r.kept_out_rms_px, r.straightness_px);
  for (std::size_t v = 0; v < r.views.size(); ++v)
    text += fmt::format("  {:.3f} px  {}{}\n", r.views[v].rms_px, report.names[v],
                        r.views[v].used ? "" : "  dropped: out of proportion");
  return text;
}

std::vector<std::string> calibration_warnings(const CalibrationReport& report) {
  constexpr int kComfortable = 10;
  constexpr double kSure = 0.01, kSharp_px = 0.5;
  const CalibrationResult& r = report.result;
  std::vector<std::string> warnings;
  if (r.used < kComfortable)
    warnings.push_back(fmt::format("only {} views: take {} or more", r.used, 2 * kComfortable));
  if (r.sigma.fx > kSure * r.camera.fx)
    warnings.push_back(
        fmt::format("the focal length is known to {:.1f} % only: tilt the board more", 100 * r.sigma.fx / r.camera.fx));
  if (r.rms_px > kSharp_px)
    warnings.push_back(fmt::format(
        "an RMS of {:.2f} px is much: is the board flat, the picture sharp, the lens of this kind (--lens)?",
        r.rms_px));
  if (const std::vector<std::string> missing = missing_of(report); !missing.empty()) {
    std::string list;
    for (const std::string& what : missing) list += (list.empty() ? "" : "; ") + what;
    warnings.push_back("no view shows " + list);
  }
  return warnings;
}

Json calibration_json(const CalibrationReport& report) {
  const CalibrationResult& r = report.result;
  Json parameters = Json::object(), views = Json::array();
  for (const Parameter& p : parameters_of(r)) parameters[p.name] = {{"value", p.value}, {"sigma", p.sigma}};
  for (std::size_t v = 0; v < r.views.size(); ++v)
    views.push_back({{"name", report.names[v]}, {"rms_px", finite(r.views[v].rms_px)}, {"used", r.views[v].used}});
  return {
      {"width", r.camera.width},
      {"height", r.camera.height},
      {"lens", r.camera.lens == Lens::equidistant ? "equidistant" : "pinhole"},
      {"board", {{"columns", report.board.columns}, {"rows", report.board.rows}, {"square_m", report.board.square_m}}},
      {"parameters", parameters},
      {"rms_px", r.rms_px},
      {"kept_out_rms_px", finite(r.kept_out_rms_px)},
      {"straightness_px", finite(r.straightness_px)},
      {"used", r.used},
      {"views", views},
      {"warnings", calibration_warnings(report)}};
}

std::string calibration_picture(const CalibrationReport& report) {
  constexpr double kWidth_px = 900, kMargin = 24, kText = 15, kLine = 22, kEnlarged = 50;
  const CalibrationResult& r = report.result;
  const double scale = kWidth_px / r.camera.width;
  const Vector2d origin(kMargin, kMargin), size(kWidth_px, r.camera.height * scale);
  const auto at = [&](const Vector2d& pixel) { return Vector2d(origin + scale * (pixel + Vector2d(0.5, 0.5))); };
  svg::Writer out;
  const Coverage coverage = coverage_of(used_views(report), report.board, r.camera.width, r.camera.height);
  const Vector2d field(size.x() / Coverage::kColumns, size.y() / Coverage::kRows);
  for (int i = 0; i < Coverage::kColumns * Coverage::kRows; ++i)
    if (coverage.corners_in_field[static_cast<std::size_t>(i)] == 0)
      out.filled(origin + Vector2d(i % Coverage::kColumns, i / Coverage::kColumns).cwiseProduct(field), field,
                 "#f6c4c4");
  out.outline(origin, size, {"#222222", 1});
  std::vector<Polyline> edges, errors;
  for (std::size_t v = 0; v < r.views.size(); ++v) {
    if (!r.views[v].used) continue;
    Polyline row;
    for (int i = 0; i < report.board.corners(); ++i) {
      const Vector2d seen = report.views[v][static_cast<std::size_t>(i)];
      const Vector2d error = seen - project(r.camera, r.views[v].T_c_b * report.board.point(i));
      if (i % report.board.columns == 0 && i > 0) edges.push_back(row), row.clear();
      row.push_back(at(seen));
      errors.push_back({at(seen), at(seen + kEnlarged * error)});
    }
    edges.push_back(row);
  }
  out.path(edges, {"#9db7dd", 0.8});
  out.path(errors, {"#d62728", 1.2});
  out.circle(at({r.camera.cx, r.camera.cy}), 5, {"#2ca02c", 2});
  double y = origin.y() + size.y() + kLine;
  const auto line = [&](const std::string& text) {
    out.text({origin.x(), y}, text, {.size_px = kText});
    y += kLine;
  };
  line(fmt::format(
      "{} views. Blue: the board's rows. Red: the errors, {:.0f} times enlarged. Green: the principal point.", r.used,
      kEnlarged));
  line(fmt::format("RMS {:.3f} px, on views kept out {:.3f} px. Red fields: no corner seen there.", r.rms_px,
                   r.kept_out_rms_px));
  return out.document({kWidth_px + 2 * kMargin, y}, "pavo calibrate: coverage and errors");
}

std::string calibration_yaml(const CalibrationReport& report, const std::string& camera_name) {
  const CalibrationResult& r = report.result;
  std::string text = fmt::format("# pavo calibrate: {} views, RMS {:.3f} px, on views kept out {:.3f} px\n", r.used,
                                 r.rms_px, r.kept_out_rms_px);
  for (const Parameter& p : parameters_of(r)) text += fmt::format("# {} {:.6g} +- {:.2g}\n", p.name, p.value, p.sigma);
  return text + ros_camera_info(r.camera, camera_name);
}

}  // namespace pavo
