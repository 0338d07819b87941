// SURF-64 descriptors of given keypoints (Bay, Ess, Tuytelaars, Van Gool: "Speeded-Up Robust Features", CVIU 110,
// 2008).
#pragma once

#include <hwy/aligned_allocator.h>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "stages/features/features.h"
#include "types/image.h"

namespace pavo {

struct SurfTables;

/// Describes the 20 s x 20 s pixels around each keypoint, where s = 1.2 keypoint_size / 9: its gradients on a grid of
/// 20 x 20, weighted by a Gaussian of 3.3 s, are summed in 4 x 4 cells as (sum dx, sum dy, sum |dx|, sum |dy|).
///
/// The descriptors are those of OpenCV's implementation within its own rounding: dx runs along the keypoint's
/// direction, dy across it (90 degrees from x towards y), cell (i, j) is i-th across and j-th along. Oriented: the
/// direction is the dominant gradient's, angle_rad from x towards y (down) in [-pi, pi]. Upright: it is -y for all of
/// them, and angle_rad is 0. Pixels beyond the border repeat it. A patch without any gradient gets zeros; every other
/// has unit length.
///
/// The window is 21 s pixels a side, rounded down. Upright, an even window cannot be centred on a pixel, and goes half
/// a pixel to this or that side with the parity of the coordinate (as OpenCV's does): sizes with an odd one (9, 10.5,
/// 12, 13.5: 25, 29, 33, 37 pixels) match better from frame to frame.
///
/// All that rounds is integer, or float in a fixed order: the same bits on every SIMD target.
/// Const and without state: may be called from any threads at once, each with its own scratch.
class Surf {
 public:
  /// Allocated by the first image of its size. Not used upright.
  struct Scratch {
    hwy::AlignedFreeUniquePtr<std::uint32_t[]> integral;
    std::size_t size = 0;
  };

  static constexpr double kSmallestSize = 9;
  static constexpr double kLargestSize = 21;

  /// Throws std::runtime_error when `keypoint_size` (its diameter in pixels) is not in [kSmallestSize, kLargestSize].
  explicit Surf(double keypoint_size = 9, bool oriented = false);
  ~Surf();
  Surf(Surf&&) noexcept;
  Surf& operator=(Surf&&) noexcept;

  /// Fills the descriptors of features.keypoints, and their angles. Allocates only what features and scratch lack.
  void operator()(ImageView image, Features& features, Scratch& scratch) const;

  /// No pixel farther than this from a keypoint (at an integer pixel), in x or y, is read for it.
  int support() const;

 private:
  std::unique_ptr<const SurfTables> tables_;
};

}  // namespace pavo
