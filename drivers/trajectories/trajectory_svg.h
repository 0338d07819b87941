// Trajectories as a picture for a paper: the paths from above, x to the right, z up, metres, equal aspect.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "types/pose.h"

namespace pavo {

/// The colours of the curves: the truth red, plain geometry green, pavo blue; the rest for further estimates.
inline constexpr const char* kTruthColor = "#d62728";
inline constexpr const char* kGeometricColor = "#2ca02c";
inline constexpr const char* kPavoColor = "#1f5fd0";
inline constexpr const char* kMoreColors[] = {"#e68a00", "#8e44ad", "#00939c", "#7f5539", "#d6519d", "#666666"};

struct PlotCurve {
  std::string label;       ///< in the legend, any UTF-8 (escaped here): say how the curve was aligned
  std::string color;       ///< "#rrggbb"
  Trajectory trajectory;   ///< in the world that all curves share: aligned by the caller
  bool reference = false;  ///< drawn broad, beneath the others, so that a perfect estimate hides nothing
};

struct TrajectoryPlot {
  std::string title;              ///< "" = none
  std::string note;               ///< one more line of the legend: "estimates aligned by Sim(3)"
  std::vector<PlotCurve> curves;  ///< drawn in this order, references first
  std::string unit = "m";         ///< of the axes and the scale bar
};

/// Points that change no more than a fraction of a pixel are left out (Douglas and Peucker, Cartographica 1973), and a
/// curve has at most this many, whatever its length.
inline constexpr std::size_t kMostPointsPerCurve = 4000;

/// The SVG's text: the same bytes for the same plot, in every locale. A position that is not finite (or beyond 1e9 m)
/// is a gap in its curve; no curve, or none with a point, gives empty axes. Pure; any thread may call it.
std::string trajectory_svg(const TrajectoryPlot& plot);

/// Writes it (see write_whole_file). Throws std::runtime_error with the path and the reason.
void write_trajectory_svg(const std::string& path, const TrajectoryPlot& plot);

}  // namespace pavo
