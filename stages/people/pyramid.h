// The sizes at which an image is searched, and its pixels at each of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "stages/people/hog.h"
#include "types/image.h"

namespace pavo::hog {

/// How a level is made from the image.
enum class Sampling {
  /// By a triangle filter that leaves every level as soft as the pictures of the training are: the sum of the variances
  /// of
  /// all its filters is kBlur. Without it, the classifier learns that people are soft and the rest is sharp, and finds
  /// nobody
  /// in sharp images (measured: models/README.md).
  as_soft_as_training,
  as_is,  ///< level 0 is the image itself: for pictures of the training
};

/// px^2 of a level. Made so that |gradient| / |gradient after a Gaussian of 1 px| is on negatives what it is on INRIA's
/// positives, 1.43 (a plain bilinear pyramid has 1.75 to 1.95).
inline constexpr double kBlur = 0.41;

/// Four neighbours and their weights, which sum to 2^14.
struct Taps {
  int first = 0;
  std::int16_t weights[4] = {};
};

/// One size of the image.
struct Level {
  int width = 0, height = 0;            ///< px of this level, with its border
  int border = 0;                       ///< px of this level that it has beyond each edge of the image
  double step_x = 1, step_y = 1;        ///< px of the image per px of this level
  int octave = 0;                       ///< it is sampled from the image halved so often
  bool as_is = false;                   ///< ... or is it
  std::vector<std::int32_t> offsets;    ///< for each x from -kMargin on: the first of the four pixels
  std::vector<std::int32_t> weights01;  ///< the weights of the first two (1/2^14, the first in the low half) ...
  std::vector<std::int32_t> weights23;  ///< ... and of the other two
  std::vector<Taps> rows;               ///< for each y

  /// Pixels that a row has to the left of x = 0, and to the right of the last whole cell: the edge pixel repeated.
  static constexpr int kMargin = 8;

  int cells_x() const { return width / kCell; }
  int cells_y() const { return height / kCell; }
  int windows_x() const { return cells_x() - kWindowWidth / kCell + 1; }
  int windows_y() const { return cells_y() - kWindowHeight / kCell + 1; }
  /// Where cell x begins, or cell y, in px of the image.
  double image_x(int cell) const { return (kCell * cell - border) * step_x; }
  double image_y(int cell) const { return (kCell * cell - border) * step_y; }
};

/// Level k is the image made smaller by step^k, and continued beyond its edges by `border` repetitions of its edge
/// pixels, for as long as a window fits of which at least half is image to either side. It is sampled from the image
/// halved round(log2 step^k) times. Pixels are toned and have 13 bits (0 to kPixelMax). plan() and load() are for one
/// thread at a time; row() may be called by many.
class Pyramid {
 public:
  /// Sizes for images of width x height; `border` is in pixels of each level. Allocates unless all is as it was at the
  /// last call. `step` > 1; no border with Sampling::as_is.
  void plan(int width, int height, double step, Tone tone, Sampling sampling = Sampling::as_soft_as_training,
            int border = 0);

  /// The image that row() samples; it must have the planned size. Its pixels are copied.
  void load(const ImageView& image);

  const std::vector<Level>& levels() const { return levels_; }

  /// Row y of a level, y clamped to its rows: pixel x is out[kMargin + x], from -kMargin to row_size() - kMargin - 1.
  /// `blended` is scratch of blended_size() numbers.
  void row(const Level& level, int y, std::int16_t* out, std::int16_t* blended) const;

  static std::size_t row_size(const Level& level) { return level.offsets.size(); }
  std::size_t blended_size() const { return planes_.empty() ? 0 : planes_[0].stride; }

 private:
  struct Plane {  // the image, or a half of a half of ... it
    int width = 0, height = 0;
    std::size_t stride = 0;  // with slack for a vector beyond the last pixel
    std::vector<std::int16_t> pixels;
  };
  void plan_level(double scale);
  void plan_planes(int octave);
  void tone(const ImageView& image);

  int width_ = 0, height_ = 0;
  int border_ = 0;
  double step_ = 0;
  Tone tone_ = Tone::linear;
  Sampling sampling_ = Sampling::as_is;
  std::vector<std::int16_t> toned_;  // by gray value
  std::vector<Plane> planes_;
  std::vector<Level> levels_;
};

}  // namespace pavo::hog
