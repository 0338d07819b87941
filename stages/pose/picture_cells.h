// A coarse grid over the picture: where in it something is, as a share of the whole.
#pragma once

#include <algorithm>
#include <cstddef>

namespace pavo {

/// 16 x 8 cells over a picture of width x height px. Immutable; any thread.
struct PictureCells {
  static constexpr int kColumns = 16, kRows = 8;
  static constexpr std::size_t kCount = std::size_t{kColumns} * kRows;

  int width, height;

  /// Of a pixel; one beyond the picture counts for the cell at its edge.
  int column(float x) const { return place(x, width, kColumns); }
  int row(float y) const { return place(y, height, kRows); }
  static std::size_t index(int row, int column) {
    const int at = row * kColumns + column;
    return static_cast<std::size_t>(at);
  }
  std::size_t index_of(float x, float y) const { return index(row(y), column(x)); }

 private:
  static int place(float at, int size, int cells) {
    return std::clamp(static_cast<int>(at * static_cast<float>(cells) / static_cast<float>(size)), 0, cells - 1);
  }
};

}  // namespace pavo
