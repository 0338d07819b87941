// The stage `scan` as the config wants it.
#pragma once

#include <optional>

#include "pavo/config.h"
#include "stages/people/people_mask.h"
#include "stages/people/scan.h"
#include "stages/people/standing_prior.h"
#include "types/camera.h"
#include "types/spread.h"

namespace pavo {

/// Where people stand in the pictures of this (rectified) camera; nothing where its height is not known.
std::optional<StandingPrior> standing_prior(const Config& config, const Camera& camera);

/// Whose features odometry drops.
PeopleMaskOptions people_mask_options(const Config& config);

/// `spread`: who helps with one frame; null: nobody. Throws what reading the model file throws.
ScanPeople make_scan(const Config& config, const Camera& camera, Spread* spread = nullptr);

}  // namespace pavo
