// The cross-section of the street, metres from its centre line, the same on both sides.
#pragma once

#include <cmath>
#include <cstdint>

#include "drivers/synthetic/path.h"
#include "drivers/synthetic/random.h"

namespace pavo::synthetic {

constexpr double kKerb = 4.8;         ///< the road ends, the sidewalk begins
constexpr double kKerbHeight = 0.12;  ///< of the sidewalk above the road
constexpr double kParking = 3.85;     ///< middle of the parked cars
constexpr double kParkingSlot = 6.2;  ///< length of a place to park
constexpr double kFurniture = 5.25;   ///< lamp posts, trees
constexpr double kFacade = 8.6;       ///< the fronts of the houses
constexpr double kGroundPeriod = 80;  ///< the ground's textures repeat after so many metres

/// Whether a car is parked around s, on the right (side 1) or the left (-1).
inline bool is_parked(std::uint32_t seed, const Path& path, double s, int side) {
  const int slot = static_cast<int>(std::floor(path.wrap(s) / kParkingSlot));
  const double end = (slot + 1) * kParkingSlot;
  return hash(seed, 5, static_cast<std::uint32_t>(slot), static_cast<std::uint32_t>(side)) % 100 < 42 &&
         (!path.loop() || end < path.end());
}

}  // namespace pavo::synthetic
