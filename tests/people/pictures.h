// Pictures for the tests of the people stages.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "types/image.h"
#include "types/pedestrian_model.h"

namespace pavo::test {

/// Blobs, edges and noise: gradients of all sizes and directions.
inline Image textured(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  std::vector<double> pixels(static_cast<std::size_t>(width * height), 90.0);
  for (int k = 0; k < width * height / 400 + 4; ++k) {
    const int x0 = below(width), y0 = below(height), radius = 3 + below(30);
    const double gray = below(256), tilt = below(100) / 50.0 - 1;
    for (int y = std::max(0, y0 - radius); y < std::min(height, y0 + radius); ++y)
      for (int x = std::max(0, x0 - radius); x < std::min(width, x0 + radius); ++x)
        if (std::abs(x - x0 + tilt * (y - y0)) < radius / 2) pixels[static_cast<std::size_t>(y * width + x)] = gray;
  }
  Image image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double noise = y < height / 2 ? below(5) - 2 : 0;
      image.at(x, y) =
          static_cast<std::uint8_t>(std::clamp(pixels[static_cast<std::size_t>(y * width + x)] + noise, 0.0, 255.0));
    }
  return image;
}

/// A classifier of random weights, calibrated 1:1.
inline PedestrianModel random_model(unsigned seed) {
  std::mt19937 random(seed);
  PedestrianModel model;
  for (std::size_t i = 0; i < PedestrianModel::kWeights; ++i)
    model.weights.push_back(static_cast<float>(random() % 2001) / 1000 - 1);
  model.bias = -0.25f;
  return model;
}

}  // namespace pavo::test
