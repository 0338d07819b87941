#include "stages/people/standing_prior.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "stages/people/person_window.h"

namespace pavo {
namespace {

struct Feet {
  double highest, lowest;  // rows of the image
};

Feet feet_of(const StandingPrior& g, double person_px) {
  return {g.horizon_px + person_px * g.camera_height_m / g.most_m - g.slack_px,
          g.horizon_px + person_px * g.camera_height_m / g.least_m + g.slack_px};
}

}  // namespace

void check(const StandingPrior& g) {
  if (!std::isfinite(g.horizon_px)) throw std::invalid_argument("ground: the horizon must be finite");
  if (!(g.camera_height_m > 0) || !std::isfinite(g.camera_height_m))
    throw std::invalid_argument("ground: the camera's height must be above 0");
  if (!(g.slack_px >= 0) || !std::isfinite(g.slack_px))
    throw std::invalid_argument("ground: the slack must not be negative");
  if (!(g.least_m > 0 && g.most_m >= g.least_m) || !std::isfinite(g.most_m))
    throw std::invalid_argument("ground: a person's height must be above 0, the least not above the most");
}

WindowRows rows_on_ground(const StandingPrior& ground, const hog::Level& level) {
  const double window = hog::kWindowHeight * level.step_y;
  const double person = static_cast<double>(kPersonShareOfWindow) * window;
  const Feet feet = feet_of(ground, person);
  // The feet of row r are at image_y(r) + (window + person) / 2.
  const double first = level.image_y(0) + (window + person) / 2, step = hog::kCell * level.step_y;
  const auto row = [&](double y) {
    return std::clamp((y - first) / step, -1.0, static_cast<double>(level.windows_y()));
  };
  return {std::max(0, static_cast<int>(std::ceil(row(feet.highest)))),
          std::min(level.windows_y(), static_cast<int>(std::floor(row(feet.lowest))) + 1)};
}

bool stands_on_ground(const StandingPrior& ground, const PersonBox& person) {
  const Feet feet = feet_of(ground, static_cast<double>(person.height));
  const double at = static_cast<double>(person.y) + static_cast<double>(person.height);
  return at >= feet.highest && at <= feet.lowest;
}

void keep_who_stands(const StandingPrior& ground, Detections& people) {
  std::erase_if(people, [&](const PersonBox& p) { return !stands_on_ground(ground, p); });
}

}  // namespace pavo
