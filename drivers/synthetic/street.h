// What stands along the street: houses, trees, lamp posts, parked cars.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/synthetic/part.h"
#include "drivers/synthetic/path.h"
#include "drivers/synthetic/surfaces.h"

namespace pavo::synthetic {

/// Immutable once it is built.
class Street {
 public:
  Street(const Path& path, std::uint32_t seed, float texel_m, int threads);
  Street(const Street&) = delete;  // its parts point at its surfaces
  Street& operator=(const Street&) = delete;

  const Surfaces& surfaces() const { return surfaces_; }
  /// Appends what stands between s0 and s1.
  void collect(double s0, double s1, std::vector<const Part*>& parts, std::vector<const GroundShade*>& shades) const;

 private:
  struct Thing {
    double s0 = 0, s1 = 0;
    std::size_t part = 0, parts = 0, shade = 0, shades = 0;
  };
  class Builder;

  const Path& path_;
  Surfaces surfaces_;
  std::vector<Polyhedron> car_bodies_, car_cabins_;
  std::vector<Part> parts_;
  std::vector<GroundShade> shades_;
  std::vector<Thing> things_;  ///< by rising s0
};

}  // namespace pavo::synthetic
