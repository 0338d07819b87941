// Who walks where on the street.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/synthetic/body.h"
#include "drivers/synthetic/path.h"

namespace pavo::synthetic {

/// One person's way, in the street's coordinates (s, l), a broken line over time.
struct Walker {
  int id = 0;
  bool companion = false;
  std::uint32_t look_seed = 0;
  // passers-by: along the street until t_cross, then across it to the other sidewalk, then along again
  double s0 = 0, l0 = 0, l1 = 0, speed_mps = 1.3, before = 1, after = 1, t_cross = 0;
  bool crosses = false;
  // companions: a place ahead of the camera
  double ahead = 0, beside = 0, sway = 0, phase = 0;
};

class Walkers {
 public:
  Walkers(const SyntheticOptions& options, const Drive& drive, std::uint32_t seed);

  const std::vector<Walker>& all() const { return walkers_; }
  /// Where the walker is in a frame, and how he steps; false: far from the camera.
  bool stride(const Walker& walker, int frame, const Drive& drive, Stride& out) const;

 private:
  void add_passers_by(const SyntheticOptions& options, const Drive& drive, std::uint32_t seed, Random& random);
  void add_companions(int count, Random& random);
  bool is_safe(const Walker& walker, const Drive& drive) const;

  std::vector<Walker> walkers_;
};

}  // namespace pavo::synthetic
