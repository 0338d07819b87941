// Spreads points over the picture: one in a cell. So what is rich in corners has no more to say than its share of the
// picture, and a car that drives ahead is not taken for the world ("bucketing": Kitt, Geiger and Lategahn, IV 2010).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace pavo {

/// One caller at a time; only the constructor allocates.
class PointGrid {
 public:
  /// Square cells over a picture of width x height px, as many as there may be points, none narrower than `least_px`.
  PointGrid(int width, int height, int max_points, int least_px)
      : cell_px_(std::max(static_cast<double>(least_px), std::sqrt(static_cast<double>(width) * height / max_points))),
        columns_(static_cast<int>(width / cell_px_) + 1),
        taken_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(height / cell_px_ + 1)) {}

  void clear() { std::fill(taken_.begin(), taken_.end(), std::uint8_t{0}); }

  /// Takes the cell of (x, y), a pixel in [0, width) x [0, height); false where it was taken.
  bool take(float x, float y) {
    std::uint8_t& taken = taken_[place(x, y)];
    return std::exchange(taken, std::uint8_t{1}) == 0;
  }
  bool is_taken(float x, float y) const { return taken_[place(x, y)] != 0; }

 private:
  std::size_t place(float x, float y) const {
    return static_cast<std::size_t>(y / cell_px_) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(x / cell_px_);
  }

  double cell_px_;
  int columns_;
  std::vector<std::uint8_t> taken_;
};

}  // namespace pavo
