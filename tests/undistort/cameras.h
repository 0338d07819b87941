// The lenses that the tests look through, and what they see.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "types/camera.h"
#include "types/image.h"

namespace pavo::test {

struct NamedCamera {
  std::string name;
  Camera camera;
};

inline std::vector<NamedCamera> cameras() {
  return {
      {"five coefficients (a drone)",
       {752,
        480,
        458.654,
        457.296,
        367.215,
        248.375,
        Lens::radial_tangential,
        {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}}},
      {"five coefficients with k3",
       {640, 480, 520.9, 521.0, 325.1, 249.7, Lens::radial_tangential, {0.2312, -0.7849, -0.0033, -0.0001, 0.9172}}},
      {"eight coefficients",
       {641, 363, 330, 331, 318, 180, Lens::radial_tangential, {0.3, -0.05, 0.001, -0.0007, 0.02, 0.55, 0.02, 0.005}}},
      {"fisheye",
       {512,
        512,
        190.9,
        190.9,
        254.9,
        256.9,
        Lens::equidistant,
        {0.0034823894, 0.0007150348, -0.0020532361, 0.00020293673}}},
      {"strong barrel", {320, 240, 200, 200, 160, 120, Lens::radial_tangential, {-0.35, 0.1}}},
  };
}

/// Smooth with some edges: as a picture is.
inline Image picture(int width, int height) {
  Image image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double wave = 120 + 60 * std::sin(0.11 * x + 0.05 * y) + 50 * std::cos(0.13 * y - 0.04 * x);
      const double edge = (x / 37 + y / 29) % 2 == 0 ? 12 : -12;
      image.at(x, y) = static_cast<std::uint8_t>(std::clamp(wave + edge, 0.0, 255.0));
    }
  return image;
}

/// The hardest case for rounding: every pixel is independent of its neighbours.
inline Image noise(int width, int height, std::uint32_t seed) {
  std::mt19937 random(seed);
  Image image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image.at(x, y) = static_cast<std::uint8_t>(random() % 256);
  return image;
}

}  // namespace pavo::test
