// Histograms of oriented gradients: the numbers that a window is judged by.
//
// After Dalal and Triggs, Histograms of Oriented Gradients for Human Detection, CVPR 2005: windows of 64x128 px, cells
// of 8x8, 9 unsigned orientations, blocks of 2x2 cells at every cell, L2-Hys: 7 x 15 x 36 = 3780 numbers. Where it
// departs:
// - The histogram of a cell is computed once and shared by its four blocks and by all windows. The paper weights each
//   block's pixels by a Gaussian of its own, and lets a pixel vote into the cells of the same block only, which makes
//   four times the work; what the support vector machine learns from either is equally good (measured:
//   models/README.md).
// - Votes into the two nearest orientations are the coordinates of the gradient in the basis of their directions:
//   |g| sin(theta - theta_b) / sin(20 deg) in place of |g| (theta - theta_b) / 20 deg, which is equal within 1.6 %. No
//   arc tangent and no square root; it is computed for all orientations at once as a tent, see hog_cells.h.
// - One gray channel. An image is continued beyond its edges by its edge pixels.
// - Gradients and votes are 16-bit integers, sums 32-bit: the cells are the same to the bit on every machine.
#pragma once

#include <cstddef>

#include "types/pedestrian_model.h"

namespace pavo::hog {

inline constexpr int kCell = 8;  ///< px
inline constexpr int kBins = 9;  ///< orientations; bin b is centred at (20 b + 10) degrees, x right, y down
inline constexpr int kBlockSize = 4 * kBins;  ///< numbers of one block
inline constexpr int kWindowWidth = 64;       ///< px
inline constexpr int kWindowHeight = 128;
inline constexpr int kBlocksX = 7;  ///< of a window
inline constexpr int kBlocksY = 15;
inline constexpr int kDescriptorSize = kBlocksX * kBlocksY * kBlockSize;
static_assert(kDescriptorSize == PedestrianModel::kWeights);

/// Where a number is in a window's descriptor: block by rows, in it the cell by rows, in it the orientation.
constexpr std::size_t descriptor_index(int block_y, int block_x, int cell_y, int cell_x, int bin) {
  const int index = (((block_y * kBlocksX + block_x) * 2 + cell_y) * 2 + cell_x) * kBins + bin;
  return static_cast<std::size_t>(index);
}

using Tone = HogTone;
using Options = HogOptions;

}  // namespace pavo::hog
