// From rows of pixels to cells, and from cells to blocks: the inner loops of the HOG, in SIMD.
#pragma once

#include <cstddef>
#include <cstdint>

#include "stages/people/hog.h"

namespace pavo::hog {

/// Pixels are 13-bit: the sum of 8 votes then fits 16 bits.
inline constexpr int kPixelMax = 8190;

/// A band is the 8 rows of pixels between the middles of two rows of cells, a group the 8 columns between the middles
/// of two cells. A pixel votes into the four cells around it, with bilinear weights, and all 64 of a group into the
/// same four. So a band gives, for each orientation and group, four sums: with the weights of the cell above left,
/// above right, below left, below right. They are integers, in units of 1/16 of a vote.
struct BandSums {
  std::int32_t* data;  ///< kBins planes of `plane` numbers, each holding 4 per group
  std::size_t plane;   ///< at least 4 (groups rounded up to 8) numbers
};

/// `rows` are 10 rows of pixels, from the one above the band to the one below it. Each pointer is to the first pixel of
/// the first group; readable are [-1, 8 groups rounded up to a multiple of 64].
///
/// A gradient g votes for orientation b with the tent max(0, min(u_{b-1} x g, g x u_{b+1})), where u_b is the unit
/// vector of orientation b and x the cross product: sin(20 deg) times the coordinate of g along u_b in the basis of the
/// two directions that it lies between, and 0 for the other seven.
void vote_band(const std::int16_t* const* rows, int groups, const BandSums& sums);

/// The row of cells above a band: what the band before had for it (`carry`, kBins planes) and what this band has; and
/// the new carry, for the row of cells below. With C cells, the band has C + 1 groups. `cells` are kBins planes,
/// `energy` the sums of squares of the 9 numbers of each cell. Every plane holds `stride` numbers, a multiple of 16, at
/// least C.
void gather_cells(const BandSums& sums, int cells_x, std::size_t stride, std::int32_t* carry, float* cells,
                  float* energy);

/// The row of blocks between two rows of cells, normalised by L2-Hys: 36 planes of `stride` numbers, plane (2 cell_y +
/// cell_x) kBins + bin. `epsilon` is in the unit of the cells. Planes of cells must be readable 1 number beyond
/// `stride`.
void normalise_blocks(const float* upper, const float* upper_energy, const float* lower, const float* lower_energy,
                      std::size_t columns, std::size_t stride, float epsilon, float clip, float fade, float* blocks);

}  // namespace pavo::hog
