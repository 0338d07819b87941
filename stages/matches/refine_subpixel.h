// Where exactly a matched keypoint is: corners are found on whole pixels, the patch around them says the rest.
#pragma once

#include <cstdint>
#include <span>

#include "stages/matches/matches.h"
#include "types/image.h"

namespace pavo {

/// Moves each pair's current point so that the patch around it fits the patch around its previous point best: least
/// squares over a translation and a difference in brightness, by inverse composition (Baker and Matthews, IJCV 2004),
/// whose gradients and 2x2 matrix come from the previous image once.
///
/// Pure, any thread may call it; allocates nothing, never blocks.
class RefineSubpixel {
 public:
  static constexpr int kWidth = 16;  ///< of the patch, a multiple of the SIMD width
  static constexpr int kHeight = 15;

  struct Options {
    int iterations = 6;
    float epsilon_px = 0.02f;     ///< a step shorter than this ends the iteration
    float max_shift_px = 2.0f;    ///< farther from where the keypoint was found, it is another one
    float min_eigenvalue = 2.0f;  ///< of the mean squared gradient, (gray values a pixel)^2: less is noise or a line
    float max_residual = 18.0f;   ///< root mean square difference of the aligned patches, in gray values
  };

  RefineSubpixel() = default;
  explicit RefineSubpixel(const Options& options) : options_(options) {}

  /// `refined`: one flag per pair, 1 where the alignment succeeded. A pair for which it did not (at the image's border,
  /// without texture, too far, too different) stays as it was. Returns the number of 1s. Throws std::invalid_argument
  /// when the images' sizes differ or `refined` has another length than `pairs`.
  int operator()(ImageView previous, ImageView current, std::span<PointPair> pairs,
                 std::span<std::uint8_t> refined) const;

 private:
  Options options_;
};

}  // namespace pavo
