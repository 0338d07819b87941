#include "drivers/trajectories/polyline.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pavo {
namespace {

double distance_to_segment(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d ab = b - a;
  const double length2 = ab.squaredNorm();
  const double s = length2 > 0 ? std::clamp(ab.dot(p - a) / length2, 0.0, 1.0) : 0.0;
  return (p - a - s * ab).norm();
}

Polyline douglas_peucker(const Polyline& line, double tolerance) {
  std::vector<bool> keep(line.size(), false);
  keep.front() = keep.back() = true;
  std::vector<std::pair<std::size_t, std::size_t>> open{{0, line.size() - 1}};
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    double farthest = tolerance;
    std::size_t at = first;
    for (std::size_t i = first + 1; i < last; ++i) {
      const double distance = distance_to_segment(line[i], line[first], line[last]);
      if (distance > farthest) {
        farthest = distance;
        at = i;
      }
    }
    if (at == first) continue;
    keep[at] = true;
    open.emplace_back(first, at);
    open.emplace_back(at, last);
  }
  Polyline kept;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (keep[i]) kept.push_back(line[i]);
  }
  return kept;
}

/// What Douglas and Peucker cannot do in good time (its worst case is quadratic) is cut down by leaving out every
/// other.
Polyline strided(const Polyline& line, std::size_t most) {
  const std::size_t stride = (line.size() + most - 1) / most;
  Polyline kept;
  for (std::size_t i = 0; i + 1 < line.size(); i += stride) kept.push_back(line[i]);
  kept.push_back(line.back());
  return kept;
}

}  // namespace

Polyline thinned(const Polyline& line, double tolerance, std::size_t most) {
  constexpr std::size_t kManyPoints = 20'000;
  if (line.size() <= 2) return line;
  const Polyline start = line.size() > kManyPoints ? strided(line, kManyPoints) : line;
  Polyline kept = douglas_peucker(start, tolerance);
  while (kept.size() > std::max<std::size_t>(most, 2)) {
    tolerance = std::max(2 * tolerance, 1e-6);
    kept = douglas_peucker(start, tolerance);
  }
  return kept;
}

double round_step(double at_least) {
  const double power = std::pow(10.0, std::floor(std::log10(at_least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= at_least * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

}  // namespace pavo
