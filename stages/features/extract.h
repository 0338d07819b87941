// The stage `features`: image -> features.
#pragma once

#include <cstdint>
#include <vector>

#include "stages/features/fast.h"
#include "stages/features/features.h"
#include "stages/features/grid.h"
#include "stages/features/surf.h"
#include "types/image.h"

namespace pavo {

struct FeatureOptions {
  int max_features = 2000;
  int cell_px = 64;          ///< the side of the grid's cells
  int min_score = 10;        ///< corners that are weaker than this are noise, however empty their cell
  bool descriptors = true;   ///< without, only the keypoints are found (for tracks), and nearer to the border
  bool oriented = false;     ///< descriptors turn with the image; a vehicle's camera does not roll
  double keypoint_size = 9;  ///< diameter in pixels, [Surf::kSmallestSize, Surf::kLargestSize]
};

/// FAST corners, spread over a grid, and their SURF descriptors. Keypoints are at integer pixels, row by row from the
/// top, each row from the left. None is so near to the border, or to a pixel that the mask excludes, that its circle or
/// its descriptor's window would touch it; an image smaller than that has no features. A parallel stage: const and
/// without memory of other frames. Allocates in the first call with a scratch and for a Features that has not been
/// reserved for max_features; afterwards nothing. The same bits on every SIMD target.
class ExtractFeatures {
 public:
  struct Scratch {
    FastScratch fast;
    CornerGrid::Scratch grid;
    Surf::Scratch surf;
  };

  /// For images of width x height. Where `mask` is 0 the image has no source; an empty mask excludes nothing. It is
  /// read here and not kept. Throws std::runtime_error for an option out of its range or a mask of another size.
  ExtractFeatures(const FeatureOptions& options, int width, int height, ImageView mask = {});

  /// Throws std::runtime_error for an image of another size.
  void operator()(const Image& image, Features& features, Scratch& scratch) const;

  const FeatureOptions& options() const { return options_; }

  /// How far, in x and in y, a keypoint stays away from the border and from what the mask excludes.
  int margin() const { return margin_; }

 private:
  FeatureOptions options_;
  int width_, height_;
  Surf surf_;
  int margin_;
  CornerGrid grid_;
  std::vector<std::uint8_t> allowed_;  ///< 1 for the pixels that may be keypoints, row by row
};

}  // namespace pavo
