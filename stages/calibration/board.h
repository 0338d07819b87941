// The chessboard that a camera is calibrated with, and where a picture shows it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "types/image.h"

namespace pavo {

/// A printed chessboard, told by its inner corners: 10x7 squares have 9x6 of them. Its frame has the first corner as
/// its origin, x along a row, y along a column, z = x cross y.
struct Board {
  int columns = 9, rows = 6;  ///< inner corners
  double square_m = 0.04;

  int corners() const { return columns * rows; }
  /// Of corner i, in the order in which find_board() gives them: row by row.
  Eigen::Vector3d point(int i) const { return {i % columns * square_m, i / columns * square_m, 0}; }
};

/// Where one picture shows the board's corners, in pixels.
using BoardCorners = std::vector<Eigen::Vector2d>;

enum class BoardSearch {
  thorough,  ///< enlarges the picture and looks again where nothing is found: for pictures
  quick,     ///< gives up soon where there is no board: for a camera
};

/// All corners of the board, or nothing (empty). Found as Duda and Frese do (BMVC 2018, cv::findChessboardCornersSB),
/// then moved to where the gradients around are orthogonal to the way there (cv::cornerSubPix, Foerstner 1987), which
/// is three times as exact. The board needs a white margin. Throws std::invalid_argument where the board has fewer than
/// 3 corners a side, or the picture is empty. Any thread; allocates.
BoardCorners find_board(const ImageView& picture, const Board& board, BoardSearch search = BoardSearch::thorough);

}  // namespace pavo
