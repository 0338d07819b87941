// Exact mutual nearest neighbours in descriptor space, with the ratio test (Lowe, IJCV 2004).
#pragma once

#include <hwy/aligned_allocator.h>
#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <vector>

#include "stages/features/features.h"
#include "stages/matches/matches.h"
#include "types/spread.h"

namespace pavo {

/// Finds the pairs (i, j) where j is the nearest of all current descriptors to i, i is the nearest of all previous ones
/// to j, and the distance to j is below `ratio` times that to i's second nearest.
///
/// Exact: distances are L2, compared as the sum in double of (double(a_k) - double(b_k))^2, k ascending; of equal ones
/// the lowest index is the nearest, and where there is no second one the ratio test passes. So the result is the same
/// on every SIMD target, and with any number of helpers. (A kernel on 16-bit integers finds the
/// candidates; what its rounding error, which is known, leaves open is decided in double.) It does not matter whether
/// the descriptors have unit length. One with a NaN or an infinity is matched with nothing.
///
/// Pure, so that any thread may call it with a Scratch of its own. Allocates only when there are more features than
/// ever before in this Scratch or in `out`. Never blocks, never throws but std::bad_alloc.
class MatchNearest {
 public:
  struct Options {
    float ratio = 0.8f;  ///< of the nearest to the second nearest distance, in (0, 1]; 1 or more: no ratio test
    float max_displacement_px = 0;  ///< pairs that moved farther in the image are dropped at the end; 0 = off
    Spread* spread = nullptr;       ///< who helps with the search; null: nobody. Must outlive the stage
  };
  struct Scratch;

  MatchNearest() = default;
  /// Throws std::invalid_argument when an option is not positive or not a number.
  explicit MatchNearest(const Options& options);

  /// `keep_*`: one flag per keypoint, 0 = as if it were not there (it is on a person); an empty span keeps all.
  /// `out` is replaced; ascending by Match::previous; Match::distance is L2. Throws std::invalid_argument when the
  /// length of a keep list is neither 0 nor the number of keypoints.
  void operator()(const Features& previous, const Features& current, std::span<const std::uint8_t> keep_previous,
                  std::span<const std::uint8_t> keep_current, Matches& out, Scratch& scratch) const;

  void operator()(const Features& previous, const Features& current, Matches& out, Scratch& scratch) const {
    (*this)(previous, current, {}, {}, out, scratch);
  }

 private:
  Options options_;
};

/// The memory of one caller. Scores are -d^2 / 2 of descriptors that were scaled and rounded to 16 bits: the larger,
/// the nearer.
struct MatchNearest::Scratch {
  template <class T>
  struct Array {
    hwy::AlignedFreeUniquePtr<T[]> data;
    std::size_t capacity = 0;
    void reserve(std::size_t n) {
      if (n <= capacity) return;
      data = hwy::AllocateAligned<T>(n);
      if (!data) throw std::bad_alloc();
      capacity = n;
    }
  };
  /// The descriptors that take part, of one side.
  struct Side {
    std::vector<int> index;          ///< position among those that take part -> index of the keypoint
    std::vector<const float*> rows;  ///< their descriptors
    Array<std::int16_t> quantised;
    Array<std::int32_t> half_norm;
    Array<std::int32_t> score, second;  ///< of the nearest and the second nearest of the other side
    Array<std::int32_t> nearest;        ///< see nearest_kernel.h; of current: decided in double, or -1
    double largest_error = 0;           ///< length of what the rounding cost, in quantised units
  };
  Side previous, current;
  Array<std::int32_t> lane_score, lane_second, lane_column;
  Array<std::int32_t> panels, panel_half_norm;
  Array<std::int32_t> band_score, band_second;  ///< of current's, one for each band of rows
  Array<std::int32_t> near;
};

/// The coordinates of matched keypoints, in the order of `matches`. Allocates only to grow `out`.
void pairs_of(const Matches& matches, const Features& previous, const Features& current, PointPairs& out);

}  // namespace pavo
