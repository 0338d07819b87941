#include "stages/people/calibrate.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <vector>

namespace pavo {
namespace {

struct Case {
  double margin, target, weight;
};

/// Weighted negative log likelihood, in a form that does not overflow.
double loss(const std::vector<Case>& cases, const Sigmoid& s) {
  double sum = 0;
  for (const Case& c : cases) {
    const double z = s.slope * c.margin + s.offset;
    sum += c.weight * (std::max(z, 0.0) - c.target * z + std::log1p(std::exp(-std::abs(z))));
  }
  return sum;
}

/// One Newton step with a backtracking line search; false when nothing is gained any more.
bool improve(const std::vector<Case>& cases, Sigmoid& s, double& value) {
  double ga = 0, gb = 0, haa = 1e-12, hab = 0, hbb = 1e-12;
  for (const Case& c : cases) {
    const double p = 1 / (1 + std::exp(-(s.slope * c.margin + s.offset)));
    const double g = c.weight * (p - c.target), h = c.weight * p * (1 - p);
    ga += g * c.margin, gb += g;
    haa += h * c.margin * c.margin, hab += h * c.margin, hbb += h;
  }
  const double det = haa * hbb - hab * hab;
  if (!(det > 0)) return false;
  const double da = -(hbb * ga - hab * gb) / det, db = -(haa * gb - hab * ga) / det;
  const double descent = ga * da + gb * db;
  // NOLINTNEXTLINE(clang-analyzer-security.FloatLoopCounter): halving is exact
  for (double step = 1; step > 1e-10; step /= 2) {
    const Sigmoid next{s.slope + step * da, s.offset + step * db};
    const double v = loss(cases, next);
    if (v < value + 1e-4 * step * descent) {
      const bool worth_it = value - v > 1e-12 * value;
      s = next;
      value = v;
      return worth_it;
    }
  }
  return false;
}

}  // namespace

Sigmoid fit_sigmoid(std::span<const double> positives, std::span<const double> negatives, double positive_weight) {
  if (positives.empty() || negatives.empty())
    throw std::invalid_argument("calibration: needs examples of both classes");
  const auto np = static_cast<double>(positives.size()), nn = static_cast<double>(negatives.size());
  std::vector<Case> cases;
  cases.reserve(positives.size() + negatives.size());
  for (const double m : positives) cases.push_back({m, (np + 1) / (np + 2), positive_weight});
  for (const double m : negatives) cases.push_back({m, 1 / (nn + 2), 1.0});
  Sigmoid s{0, std::log((np * positive_weight + 1) / (nn + 1))};
  double value = loss(cases, s);
  for (int i = 0; i < 100 && improve(cases, s, value); ++i) {
  }
  if (!(s.slope > 0) || !std::isfinite(s.slope) || !std::isfinite(s.offset))
    throw std::invalid_argument("calibration: the margins of positives are not above those of negatives");
  return s;
}

double threshold_for(std::span<const double> false_alarms, std::size_t allowed) {
  if (false_alarms.size() <= allowed) return -std::numeric_limits<double>::infinity();
  std::vector<double> sorted(false_alarms.begin(), false_alarms.end());
  const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(allowed);
  std::nth_element(sorted.begin(), at, sorted.end(), std::greater<>());
  return std::nextafter(*at, std::numeric_limits<double>::infinity());
}

}  // namespace pavo
