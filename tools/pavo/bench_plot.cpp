#include "tools/pavo/bench_plot.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/trajectories/polyline.h"
#include "drivers/trajectories/svg_writer.h"

namespace pavo {
namespace {

using Eigen::Vector2d;
using svg::TextStyle;

constexpr double kWidth_px = 760, kPanel_px = 250, kLeft_px = 70, kRight_px = 24, kTop_px = 70, kGap_px = 86;
constexpr double kTick_px = 13;
constexpr std::array<const char*, 6> kColors{"#0072b2", "#009e73", "#e69f00", "#d55e00", "#cc79a7", "#56b4e9"};
constexpr const char* kGrid = "#dddddd";
constexpr std::size_t kMostPoints = 1000;

constexpr double kLegend_px = 20;

// A rectangle with a linear axis each way.
struct Panel {
  double top_px = 0, x_low = 0, x_high = 1, y_high = 1;

  Vector2d at(double x, double y) const {
    const double u = (x - x_low) / std::max(x_high - x_low, 1e-12), v = std::min(y / y_high, 1.0);
    return {kLeft_px + u * (kWidth_px - kLeft_px - kRight_px), top_px + (1 - v) * kPanel_px};
  }
  Polyline line(const Polyline& points) const {
    Polyline drawn;
    for (const Vector2d& p : points) drawn.push_back(at(p.x(), p.y()));
    return thinned(drawn, 0.2, kMostPoints);
  }
};

const char* color_of(std::size_t load) {
  return kColors[load % kColors.size()];
}

void draw_frame(svg::Writer& out, const Panel& panel, const std::string& title, const std::string& x_label) {
  out.text({kLeft_px, panel.top_px - 12}, title, {.size_px = 15, .bold = true});
  const double step = round_step(panel.y_high / 6);
  for (double y = 0; y <= panel.y_high * (1 + 1e-9); y += step) {
    out.path({{panel.at(panel.x_low, y), panel.at(panel.x_high, y)}}, {.color = kGrid});
    out.text(panel.at(panel.x_low, y) + Vector2d(-8, 4), svg::tick(y, step), {.size_px = kTick_px, .anchor = "end"});
  }
  out.text({18, panel.top_px + kPanel_px / 2}, "ms", {.anchor = "middle", .upwards = true});
  out.text({(kLeft_px + kWidth_px - kRight_px) / 2, panel.top_px + kPanel_px + 42}, x_label, {.anchor = "middle"});
}

void draw_tick(svg::Writer& out, const Panel& panel, double x, const std::string& label) {
  out.path({{panel.at(x, 0), panel.at(x, panel.y_high)}}, {.color = kGrid});
  out.text(panel.at(x, 0) + Vector2d(0, 19), label, {.size_px = kTick_px, .anchor = "middle"});
}

// 0 at the minimum, 1 at 90 %, 2 at 99 %, ...
double nines(double share_below) {
  return -std::log10(1 - share_below);
}

Polyline distribution(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  Polyline line;
  const auto n = static_cast<double>(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) line.push_back({nines(static_cast<double>(i) / n), values[i]});
  return line;
}

void draw_distributions(svg::Writer& out, const BenchResult& result, double top_px) {
  double most = 1e-9, widest = 1;
  for (const BenchedLoad& load : result.loads)
    for (const double ms : load.all_ms) most = std::max(most, ms);
  for (const BenchedLoad& load : result.loads)
    widest = std::max(widest, std::log10(static_cast<double>(load.all_ms.size())));
  const Panel panel{top_px, 0, std::ceil(widest), most * 1.05};
  draw_frame(out, panel, "Age of data when the pose is there", "percentile");
  draw_tick(out, panel, 0, "0");
  for (int k = 1; k <= static_cast<int>(panel.x_high); ++k) {
    const std::string nine = k == 1 ? "90" : k == 2 ? "99" : "99." + std::string(static_cast<std::size_t>(k - 2), '9');
    draw_tick(out, panel, k, nine + " %");
  }
  draw_tick(out, panel, nines(0.5), "50 %");
  for (std::size_t i = 0; i < result.loads.size(); ++i)
    out.path({panel.line(distribution(result.loads[i].all_ms))}, {.color = color_of(i), .width_px = 2});
}

void draw_over_time(svg::Writer& out, const BenchResult& result, double top_px) {
  double most = 1e-9, longest = 1e-9;
  for (const BenchedLoad& load : result.loads)
    for (const BenchSample& sample : load.samples) {
      most = std::max(most, sample.age_ms);
      longest = std::max(longest, sample.t_s);
    }
  const Panel panel{top_px, 0, longest, most * 1.05};
  draw_frame(out, panel, "Age of data over time (the first run of each load)", "s");
  const double step = round_step(longest / 8);
  for (double t = 0; t <= longest * (1 + 1e-9); t += step) draw_tick(out, panel, t, svg::tick(t, step));
  for (std::size_t i = 0; i < result.loads.size(); ++i) {
    Polyline line;
    for (const BenchSample& sample : result.loads[i].samples) line.push_back({sample.t_s, sample.age_ms});
    out.path({panel.line(line)}, {.color = color_of(i), .width_px = 1.3});
  }
}

// Returns how much more room than one line it took.
double draw_legend(svg::Writer& out, const BenchResult& result) {
  double x = kLeft_px, y = 0;
  for (std::size_t i = 0; i < result.loads.size(); ++i) {
    const BenchRun& run = result.loads[i].median;
    const std::string label = fmt::format("{:.0f} %: {:.1f} frames/s", run.load_percent, run.offered_fps);
    const double width = 28 + svg::text_width_px(label, kTick_px);
    if (x + width > kWidth_px) {
      x = kLeft_px;
      y += kLegend_px;
    }
    out.path({{Vector2d(x, 39 + y), Vector2d(x + 22, 39 + y)}}, {.color = color_of(i), .width_px = 3});
    out.text({x + 28, 44 + y}, label, {.size_px = kTick_px});
    x += width + 14;
  }
  return y;
}

}  // namespace

std::string bench_svg(const BenchResult& result) {
  svg::Writer out;
  const std::string title = fmt::format("pavo bench, {}: capacity {:.1f} frames a second ({}, {} workers)",
                                        result.source, result.capacity_fps, result.mode, result.workers);
  out.text({kLeft_px, 24}, title, {.size_px = 16, .bold = true});
  const double first = kTop_px + 18 + draw_legend(out, result), second = first + kPanel_px + kGap_px;
  draw_distributions(out, result, first);
  draw_over_time(out, result, second);
  const double end = second + kPanel_px + 72;
  out.text({kLeft_px, end - 12},
           fmt::format("{}, {} cores, governor {}, {}", result.machine.cpu, result.machine.cores,
                       result.machine.governor, result.machine.kernel),
           {.size_px = 12, .color = "#666666"});
  return out.document({kWidth_px, end}, title);
}

}  // namespace pavo
