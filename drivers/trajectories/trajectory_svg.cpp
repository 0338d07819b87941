#include "drivers/trajectories/trajectory_svg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "drivers/trajectories/append_file.h"
#include "drivers/trajectories/polyline.h"
#include "drivers/trajectories/svg_writer.h"

namespace pavo {
namespace {

using Eigen::Vector2d;

constexpr double kLargest_px = 640;   // the longer side of the axes
constexpr double kSmallest_px = 300;  // the shorter side
constexpr double kMargin = 0.06;      // of the longer side, around the curves
constexpr double kLeast_m = 0.2;      // a camera that stands still is a point, its jitter no journey
constexpr double kTick_px = 62;       // between grid lines, at least
constexpr double kLeft_px = 72, kRight_px = 24, kBottom_px = 58, kTop_px = 18;
constexpr double kText_px = 14, kTickText_px = 13, kTitle_px = 17, kLine_px = 23;
constexpr double kThinning_px = 0.1;
constexpr const char* kInk = "#222222";

struct Curve {
  const PlotCurve* source = nullptr;
  std::vector<Polyline> pieces;  // metres, then pixels; broken where a position is not finite
  Vector2d first{0, 0}, last{0, 0};
};

struct Box {
  Vector2d low{0, 0}, high{0, 0};
  Vector2d size() const { return high - low; }
  Vector2d centre() const { return (low + high) / 2; }
  bool contains(const Vector2d& p) const {
    return (p.array() >= low.array()).all() && (p.array() <= high.array()).all();
  }
};

std::vector<Polyline> pieces_from_above(const Trajectory& trajectory) {
  std::vector<Polyline> pieces;
  bool open = false;
  for (const SE3& T_w_c : trajectory.T_w_c) {
    const Vector2d point(T_w_c.t.x(), T_w_c.t.z());
    const bool drawable = point.allFinite() && point.cwiseAbs().maxCoeff() <= 1e9;
    if (drawable && !open) pieces.emplace_back();
    if (drawable) pieces.back().push_back(point);
    open = drawable;
  }
  return pieces;
}

std::vector<Curve> curves_from_above(const TrajectoryPlot& plot) {
  std::vector<Curve> curves;
  for (const bool references : {true, false}) {
    for (const PlotCurve& curve : plot.curves) {
      if (curve.reference == references) curves.push_back({&curve, pieces_from_above(curve.trajectory)});
    }
  }
  return curves;
}

Box bounds(const std::vector<Curve>& curves) {
  Box box;
  bool first = true;
  for (const Curve& curve : curves) {
    for (const Polyline& piece : curve.pieces) {
      for (const Vector2d& p : piece) {
        box.low = first ? p : Vector2d(box.low.cwiseMin(p));
        box.high = first ? p : Vector2d(box.high.cwiseMax(p));
        first = false;
      }
    }
  }
  return box;
}

/// Where metres go on the paper: one scale for both axes.
struct Axes {
  Box metres;
  Box paper;
  double px_per_m = 1;
  double step_m = 1;  ///< of the grid, the same for both axes

  Vector2d to_paper(const Vector2d& m) const {
    return {paper.low.x() + px_per_m * (m.x() - metres.low.x()), paper.high.y() - px_per_m * (m.y() - metres.low.y())};
  }
};

/// At least that large on the paper; its place there depends on the legend above it.
Axes fit_axes(const Box& data, const Vector2d& least_px) {
  Vector2d size = data.size().array() + 2 * kMargin * data.size().maxCoeff();
  size = size.cwiseMax(kLeast_m);
  size = size.cwiseMax(size.maxCoeff() / kLargest_px * least_px);
  Axes axes;
  axes.metres.low = data.centre() - size / 2;
  axes.metres.high = data.centre() + size / 2;
  axes.px_per_m = kLargest_px / size.maxCoeff();
  axes.step_m = round_step(kTick_px / axes.px_per_m);
  return axes;
}

void place(Axes& axes, const Vector2d& top_left) {
  axes.paper.low = top_left;
  axes.paper.high = top_left + axes.px_per_m * axes.metres.size();
}

/// Each piece has its share of the points, and two at least; of very many pieces some are left out.
void thin(std::vector<Polyline>& pieces) {
  constexpr std::size_t kMostPieces = kMostPointsPerCurve / 4;
  const std::size_t stride = (pieces.size() + kMostPieces - 1) / kMostPieces;
  std::size_t kept = 0, points = 0;
  for (std::size_t i = 0; i < pieces.size(); i += stride, ++kept) {
    if (kept != i) pieces[kept] = std::move(pieces[i]);
    points += pieces[kept].size();
  }
  pieces.resize(kept);
  for (Polyline& piece : pieces)
    piece = thinned(piece, kThinning_px, 2 + (kMostPointsPerCurve - 2 * kept) * piece.size() / points);
}

void put_on_paper(std::vector<Curve>& curves, const Axes& axes) {
  for (Curve& curve : curves) {
    if (curve.pieces.empty()) continue;
    for (Polyline& piece : curve.pieces) {
      for (Vector2d& p : piece) p = axes.to_paper(p);
    }
    curve.first = curve.pieces.front().front();
    curve.last = curve.pieces.back().back();
    thin(curve.pieces);
  }
}

void draw_grid(svg::Writer& out, const Axes& axes) {
  const Box& paper = axes.paper;
  std::vector<Polyline> grid;
  for (int axis = 0; axis < 2; ++axis) {
    const auto first = std::lround(std::ceil(axes.metres.low[axis] / axes.step_m - 1e-9));
    const auto last = std::lround(std::floor(axes.metres.high[axis] / axes.step_m + 1e-9));
    for (auto line = first; line <= last; ++line) {
      const auto k = static_cast<double>(line);
      Vector2d at = axes.metres.low;
      at[axis] = k * axes.step_m;
      const Vector2d p = axes.to_paper(at);
      const std::string label = svg::tick(k * axes.step_m, axes.step_m);
      if (axis == 0) {
        grid.push_back({{p.x(), paper.low.y()}, {p.x(), paper.high.y()}});
        out.text({p.x(), paper.high.y() + 18}, label, {.size_px = kTickText_px, .anchor = "middle"});
      } else {
        grid.push_back({{paper.low.x(), p.y()}, {paper.high.x(), p.y()}});
        out.text({paper.low.x() - 8, p.y() + 4.5}, label, {.size_px = kTickText_px, .anchor = "end"});
      }
    }
  }
  out.path(grid, {"#e4e4e4", 1});
}

void draw_frame(svg::Writer& out, const Axes& axes, const std::string& unit) {
  const Box& paper = axes.paper;
  out.outline(paper.low, paper.size(), {"#888888", 1});
  out.text({paper.centre().x(), paper.high.y() + 42}, "x (" + unit + ")", {.size_px = kText_px, .anchor = "middle"});
  out.text({paper.low.x() - 50, paper.centre().y()}, "z (" + unit + ")",
           {.size_px = kText_px, .anchor = "middle", .upwards = true});
}

svg::Stroke stroke(const PlotCurve& curve) {
  return curve.reference ? svg::Stroke{curve.color, 2.8, 0.75} : svg::Stroke{curve.color, 1.5};
}

/// A circle that the end's square fits into, so that both are seen where a path ends at its start.
void mark_start(svg::Writer& out, const Vector2d& p, const std::string& color) {
  out.circle(p, 6, {color, 1.6});
}
void mark_end(svg::Writer& out, const Vector2d& p, const std::string& color) {
  out.filled(p - Vector2d(3.5, 3.5), {7, 7}, color);
}

void draw_curves(svg::Writer& out, const std::vector<Curve>& curves) {
  for (const Curve& curve : curves) {
    if (!curve.pieces.empty()) out.path(curve.pieces, stroke(*curve.source));
  }
  for (const Curve& curve : curves) {
    if (curve.pieces.empty()) continue;
    mark_end(out, curve.last, curve.source->color);
    mark_start(out, curve.first, curve.source->color);
  }
}

/// How many points, set every few pixels along the curves, lie in the box.
std::size_t crowding(const std::vector<Curve>& curves, const Box& box) {
  constexpr double kEvery_px = 4;
  std::size_t count = 0;
  for (const Curve& curve : curves) {
    for (const Polyline& piece : curve.pieces) {
      for (std::size_t i = 0; i < piece.size(); ++i) {
        const Vector2d step = i == 0 ? Vector2d(0, 0) : Vector2d(piece[i] - piece[i - 1]);
        const int samples = 1 + static_cast<int>(step.norm() / kEvery_px);
        for (int s = 0; s < samples; ++s) count += box.contains(piece[i] - step * s / samples) ? 1 : 0;
      }
    }
  }
  return count;
}

/// In the emptiest corner; the lower right one where they are equal.
void draw_scale_bar(svg::Writer& out, const Axes& axes, const std::vector<Curve>& curves, const std::string& unit) {
  const double length_m = round_step(0.12 * axes.paper.size().x() / axes.px_per_m);
  const double bar_px = length_m * axes.px_per_m;
  const std::string label = svg::tick(length_m, length_m) + " " + unit;
  const Vector2d size(std::max(bar_px, svg::text_width_px(label, kTickText_px)) + 20, 38);
  const Vector2d low = axes.paper.low + Vector2d(10, 10);
  const Vector2d high = axes.paper.high - size - Vector2d(10, 10);

  const std::array<Vector2d, 4> corners{high, Vector2d(low.x(), high.y()), Vector2d(high.x(), low.y()), low};
  const Vector2d corner = *std::min_element(corners.begin(), corners.end(), [&](const Vector2d& a, const Vector2d& b) {
    return crowding(curves, {a, a + size}) < crowding(curves, {b, b + size});
  });

  const Vector2d middle = corner + Vector2d(size.x() / 2, 28), half(bar_px / 2, 0), tick(0, 4);
  out.filled(corner, size, "#ffffff", 0.85);
  out.outline(corner, size, {"#cccccc", 1});
  out.path({{middle - half, middle + half},
            {middle - half - tick, middle - half + tick},
            {middle + half - tick, middle + half + tick}},
           {kInk, 1.6});
  out.text(middle - Vector2d(0, 9), label, {.size_px = kTickText_px, .anchor = "middle"});
}

/// Above the axes, where it hides nothing: the entries flow from left to right, and wrap. Returns where it ends.
double draw_legend(svg::Writer& out, const TrajectoryPlot& plot, const std::vector<Curve>& curves, double width_px) {
  Vector2d pen(kLeft_px, kTop_px);
  const auto newline = [&] { pen = {kLeft_px, pen.y() + kLine_px}; };
  const auto reserve = [&](double entry_px) {
    if (pen.x() > kLeft_px && pen.x() + entry_px > width_px - 8) newline();
    Vector2d at = pen + Vector2d(0, kLine_px / 2);
    pen.x() += entry_px;
    return at;
  };
  if (!plot.title.empty()) {
    out.text({kLeft_px, kTop_px + 12}, plot.title, {.size_px = kTitle_px, .bold = true});
    pen.y() += kLine_px + 2;
  }
  for (const Curve& curve : curves) {
    const Vector2d at = reserve(54 + svg::text_width_px(curve.source->label, kText_px));
    out.path({{at, at + Vector2d(26, 0)}}, stroke(*curve.source));
    out.text(at + Vector2d(34, 5), curve.source->label, {.size_px = kText_px});
  }
  const Vector2d at = reserve(124);  // the two marks stay together
  mark_start(out, at + Vector2d(8, 0), kInk);
  out.text(at + Vector2d(20, 5), "start", {.size_px = kText_px});
  mark_end(out, at + Vector2d(76, 0), kInk);
  out.text(at + Vector2d(86, 5), "end", {.size_px = kText_px});
  if (!plot.note.empty()) {
    newline();
    out.text(pen + Vector2d(0, kLine_px / 2 + 5), plot.note, {.size_px = kText_px, .color = "#666666"});
  }
  return pen.y() + kLine_px + 8;
}

/// What the title needs, so that it does not hang over.
double least_width_px(const TrajectoryPlot& plot) {
  const double title_px = svg::text_width_px(plot.title, 1.1 * kTitle_px);
  const double note_px = svg::text_width_px(plot.note, kText_px);
  return std::clamp(std::max(title_px, note_px), kSmallest_px, kLargest_px);
}

}  // namespace

std::string trajectory_svg(const TrajectoryPlot& plot) {
  std::vector<Curve> curves = curves_from_above(plot);
  Axes axes = fit_axes(bounds(curves), {least_width_px(plot), kSmallest_px});
  const double width_px = kLeft_px + axes.px_per_m * axes.metres.size().x() + kRight_px;

  svg::Writer out;
  place(axes, {kLeft_px, draw_legend(out, plot, curves, width_px)});
  put_on_paper(curves, axes);
  draw_grid(out, axes);
  draw_curves(out, curves);
  draw_scale_bar(out, axes, curves, plot.unit);
  draw_frame(out, axes, plot.unit);
  return out.document({width_px, axes.paper.high.y() + kBottom_px},
                      plot.title.empty() ? "Trajectories from above" : plot.title);
}

void write_trajectory_svg(const std::string& path, const TrajectoryPlot& plot) {
  write_whole_file(path, trajectory_svg(plot));
}

}  // namespace pavo
