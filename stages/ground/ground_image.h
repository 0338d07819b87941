// What the alignment of the ground reads of a frame: the rows below the horizon, smoothed, at three sizes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "types/camera.h"
#include "types/image.h"

namespace pavo {

/// Gray values times 16, after a 3x3 binomial filter: interpolation then prefers no phase of the pixels, and what JPEG
/// leaves between them is gone. Level l has 2^-l of the size; its pixel x is centred at (x + 1/2) 2^l - 1/2 of level 0.
class GroundImage {
 public:
  static constexpr int kLevels = 3;

  struct Level {
    int width = 0, height = 0;
    std::vector<std::uint16_t> pixels;
    const std::uint16_t* row(int y) const { return pixels.data() + static_cast<std::size_t>(y) * width; }
    std::uint16_t* row(int y) { return pixels.data() + static_cast<std::size_t>(y) * width; }
  };

  /// Takes the rows of `image` from `top` on. Allocates only for a larger image than ever before.
  void assign(const ImageView& image, int top);

  const Level& level(int l) const { return levels_[static_cast<std::size_t>(l)]; }
  int top() const { return top_; }  ///< row of the image that row 0 of level 0 is; a multiple of 4

 private:
  int top_ = 0;
  std::array<Level, kLevels> levels_;
  std::vector<std::uint16_t> rows_;  // of the horizontal pass
};

/// The camera as level l of a GroundImage sees it.
Camera camera_of_level(const Camera& camera, int top, int level);

}  // namespace pavo
