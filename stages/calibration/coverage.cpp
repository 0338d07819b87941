#include "stages/calibration/coverage.h"

#include <algorithm>

namespace pavo {
namespace {

int field(double position, int size, int fields) {
  return std::clamp(static_cast<int>(fields * (position + 0.5) / size), 0, fields - 1);
}

// The outline's four corners, in order around the board.
std::array<Eigen::Vector2d, 4> outline(const BoardCorners& view, const Board& board) {
  const auto at = [&](int column, int row) { return view[static_cast<std::size_t>(row * board.columns + column)]; };
  return {at(0, 0), at(board.columns - 1, 0), at(board.columns - 1, board.rows - 1), at(0, board.rows - 1)};
}

// Of two opposite sides of a tilted board the nearer one is seen longer.
void count_tilts(const std::array<Eigen::Vector2d, 4>& corners, Coverage& coverage) {
  constexpr double kTilted = 1.1;
  for (std::size_t side = 0; side < 2; ++side) {
    const Eigen::Vector2d &a = corners[side], &b = corners[side + 1], &c = corners[side + 2],
                          &d = corners[(side + 3) % 4];
    const double ratio = (b - a).norm() / (d - c).norm();
    if (ratio < kTilted && ratio > 1 / kTilted) continue;
    const Eigen::Vector2d to_nearer = (ratio > 1 ? 1. : -1.) * ((a + b) - (c + d));
    if (std::abs(to_nearer.x()) > std::abs(to_nearer.y()))
      ++(to_nearer.x() < 0 ? coverage.left_nearer : coverage.right_nearer);
    else
      ++(to_nearer.y() < 0 ? coverage.top_nearer : coverage.bottom_nearer);
  }
}

}  // namespace

Coverage coverage_of(std::span<const BoardCorners> views, const Board& board, int width, int height) {
  Coverage coverage;
  for (const BoardCorners& view : views) {
    for (const Eigen::Vector2d& p : view)
      ++coverage.corners_in_field[static_cast<std::size_t>(Coverage::kColumns * field(p.y(), height, Coverage::kRows) +
                                                           field(p.x(), width, Coverage::kColumns))];
    count_tilts(outline(view, board), coverage);
  }
  return coverage;
}

std::vector<std::string> missing_views(const Coverage& coverage) {
  constexpr int kLastColumn = Coverage::kColumns - 1, kLastRow = Coverage::kRows - 1, kEnough = 8;
  const auto corners_in = [&](int left, int top, int right, int bottom) {
    int sum = 0;
    for (int row = top; row <= bottom; ++row)
      for (int column = left; column <= right; ++column)
        sum += coverage.corners_in_field[static_cast<std::size_t>(Coverage::kColumns * row + column)];
    return sum;
  };
  struct Part {
    const char* name;
    int corners;
  };
  std::vector<std::string> missing;
  for (const Part& part :
       {Part{"middle", corners_in(2, 1, 3, 2)}, Part{"left edge", corners_in(0, 0, 0, kLastRow)},
        Part{"right edge", corners_in(kLastColumn, 0, kLastColumn, kLastRow)},
        Part{"upper edge", corners_in(0, 0, kLastColumn, 0)},
        Part{"lower edge", corners_in(0, kLastRow, kLastColumn, kLastRow)},
        Part{"top left corner", corners_in(0, 0, 1, 1)},
        Part{"top right corner", corners_in(kLastColumn - 1, 0, kLastColumn, 1)},
        Part{"bottom left corner", corners_in(0, kLastRow - 1, 1, kLastRow)},
        Part{"bottom right corner", corners_in(kLastColumn - 1, kLastRow - 1, kLastColumn, kLastRow)}})
    if (part.corners < kEnough) missing.push_back("the " + std::string(part.name) + " of the image");
  const auto need = [&](int views, const char* side) {
    if (views == 0) missing.push_back("the board tilted, its " + std::string(side) + " side nearer");
  };
  need(coverage.left_nearer, "left");
  need(coverage.right_nearer, "right");
  need(coverage.top_nearer, "upper");
  need(coverage.bottom_nearer, "lower");
  return missing;
}

}  // namespace pavo
