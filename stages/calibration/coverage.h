// Where in the image the board has been, and how it was tilted: what is still missing for a good calibration.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "stages/calibration/board.h"

namespace pavo {

struct Coverage {
  static constexpr int kColumns = 6, kRows = 4;
  std::array<int, kColumns * kRows> corners_in_field{};  ///< the image in fields, row by row from the top left
  /// Views in which the board's left, right, upper or lower side is nearer to the camera than the opposite one.
  int left_nearer = 0, right_nearer = 0, top_nearer = 0, bottom_nearer = 0;
};

/// "left" and so on are those of the image, whichever way the board is held. Pure.
Coverage coverage_of(std::span<const BoardCorners> views, const Board& board, int width, int height);

/// In words, what to show the camera: "the top left corner of the image", "the board tilted, its left side nearer".
/// Empty where nothing is missing.
std::vector<std::string> missing_views(const Coverage& coverage);

}  // namespace pavo
