// Corners spread over the image: the strongest ones of every cell of a grid, so that no facade takes what the road
// needs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "stages/features/fast.h"

namespace pavo {

/// Each cell has a threshold of its own, found within the frame: all cells may keep the same number of corners, what a
/// poor cell has not is shared out among the others (water-filling), and a cell that has more keeps its strongest.
/// Const and without state: may be called from any threads at once, each with its own scratch.
class CornerGrid {
 public:
  /// Allocated by the first call.
  struct Scratch {
    struct Cell {
      int corners = 0;
      int quota = 0;    ///< how many corners it keeps
      int weakest = 0;  ///< their smallest score
      int ties = 0;     ///< how many of that score it keeps
    };
    std::vector<Cell> cells;
    std::vector<std::uint16_t> histograms;  ///< 256 counts, one for each score, per cell
  };

  /// Cells of `cell_size` x `cell_size` pixels; those at the right and at the bottom may be cut off.
  CornerGrid(int width, int height, int cell_size, int max_corners);

  /// Moves the corners that are kept, at most max_corners, to the front, in their order, and returns them. Equally
  /// strong ones of a cell are kept first come, first served. Allocates only in the first call with a scratch.
  std::span<Corner> keep_best(std::span<Corner> corners, Scratch& scratch) const;

 private:
  int cell_of(const Corner& corner) const { return row_[corner.y] + column_[corner.x]; }
  void count(std::span<const Corner> corners, Scratch& scratch) const;
  void share_out(Scratch& scratch) const;

  std::vector<int> column_, row_;  ///< the cell of a pixel is the sum of its column's and its row's
  int cells_;
  int max_corners_;
};

}  // namespace pavo
