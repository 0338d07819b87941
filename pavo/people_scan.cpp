#include "pavo/people_scan.h"

#include <cmath>

#include "drivers/models/model_file.h"

namespace pavo {
namespace {

PedestrianModel model_of(const Config& config) {
  return config.people.model.empty() ? default_pedestrian_model() : read_pedestrian_model(config.people.model);
}

}  // namespace

std::optional<StandingPrior> standing_prior(const Config& config, const Camera& camera) {
  if (!(config.camera.height_m > 0)) return std::nullopt;
  return StandingPrior{.horizon_px = camera.cy + camera.fy * std::tan(config.camera.pitch_rad),
                       .camera_height_m = config.camera.height_m,
                       .slack_px = camera.fy * config.people.ground_slack_rad};
}

PeopleMaskOptions people_mask_options(const Config& config) {
  return {.width_factor = static_cast<float>(config.people.mask_width),
          .height_factor = static_cast<float>(config.people.mask_height),
          .ellipse = config.people.mask_shape == "ellipse"};
}

ScanPeople make_scan(const Config& config, const Camera& camera, Spread* spread) {
  ScanHogOptions options;
  options.threshold = static_cast<float>(config.people.threshold);
  options.standing = standing_prior(config, camera);
  options.spread = spread;
  return ScanPeople(model_of(config), options);
}

}  // namespace pavo
