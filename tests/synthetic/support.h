// A small street for the tests, and its frames.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "drivers/synthetic/synthetic_street.h"

namespace pavo::test {

inline SyntheticOptions small_street(int frames = 12) {
  SyntheticOptions options;
  options.width = 320;
  options.height = 96;
  options.frames = frames;
  options.noise_sigma = 0;
  options.threads = 1;
  return options;
}

struct Gray {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;

  int at(int x, int y) const { return pixels[static_cast<std::size_t>(y * width + x)]; }
  bool covers(double x, double y) const { return x >= 0 && y >= 0 && x < width - 1 && y < height - 1; }
  double between(double x, double y) const {
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    const double a = x - i, b = y - j;
    return (1 - b) * ((1 - a) * at(i, j) + a * at(i + 1, j)) + b * ((1 - a) * at(i, j + 1) + a * at(i + 1, j + 1));
  }
};

inline std::vector<Gray> read_all(SyntheticStreet& street) {
  std::vector<Gray> frames;
  EncodedImage image;
  FrameStamp stamp;
  while (street.read(image, stamp)) frames.push_back({image.width, image.height, image.bytes});
  return frames;
}

inline std::vector<Gray> render(const SyntheticOptions& options) {
  SyntheticStreet street(options);
  return read_all(street);
}

}  // namespace pavo::test
