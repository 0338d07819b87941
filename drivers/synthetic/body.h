// A walking person, made of some twenty round cones and ellipsoids.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/synthetic/part.h"
#include "drivers/synthetic/random.h"

namespace pavo::synthetic {

/// What clothes are made of.
struct Wardrobe {
  std::vector<Texture> cloths;  ///< repeat; kClothTexels texels a metre
  static constexpr float kClothTexels = 220;
};
Wardrobe make_wardrobe(std::uint32_t seed);

/// How somebody looks; a pure function of a seed.
struct Look {
  explicit Look(std::uint32_t seed);

  float height_m, girth;
  float skin, hair, top, legs, shoes, bag;  ///< albedos
  int top_cloth, legs_cloth;                ///< index into the wardrobe, modulo its size
  bool long_hair, hat, coat, skirt, short_sleeves, backpack, handbag;
  float top_contrast;
};

/// Where somebody is, and where in his stride.
struct Stride {
  Eigen::Vector3d feet{0, 0, 0};  ///< street frame, on the ground
  double heading = 0;             ///< as PathPoint's
  double phase = 0;               ///< radians, 2 pi for two steps
  double speed_mps = 1.3;         ///< sets how wide the stride is
};

/// Metres of one full stride (two steps).
double stride_length(double speed_mps);

/// Appends the parts of the body.
void build_body(const Look& look, const Stride& stride, int person, const Wardrobe& wardrobe, std::vector<Part>& parts);

}  // namespace pavo::synthetic
