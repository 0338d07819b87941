#include "stages/calibration/board.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>

namespace pavo {
namespace {

// How far from each corner its own edges reach: half way to the nearest other one, and no farther than a square that
// the lens still leaves straight.
int refinement_window(const std::vector<cv::Point2f>& corners, const Board& board) {
  constexpr double kShare = 0.4;
  constexpr int kSmallest = 2, kLargest = 6;
  double nearest = 1e9;
  for (int i = 0; i < board.corners(); ++i) {
    if (i % board.columns) nearest = std::min(nearest, cv::norm(corners[i] - corners[i - 1]));
    if (i >= board.columns) nearest = std::min(nearest, cv::norm(corners[i] - corners[i - board.columns]));
  }
  return std::clamp(static_cast<int>(kShare * nearest), kSmallest, kLargest);
}

bool find(const cv::Mat& picture, const Board& board, BoardSearch search, std::vector<cv::Point2f>& corners) {
  const cv::Size size(board.columns, board.rows);
  if (search == BoardSearch::quick)
    return cv::checkChessboard(picture, size) &&
           cv::findChessboardCornersSB(picture, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE);
  return cv::findChessboardCornersSB(picture, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE) ||
         cv::findChessboardCornersSB(picture, size, corners,
                                     cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_ACCURACY);
}

}  // namespace

BoardCorners find_board(const ImageView& picture, const Board& board, BoardSearch search) {
  if (board.columns < 3 || board.rows < 3)
    throw std::invalid_argument("the board has " + std::to_string(board.columns) + "x" + std::to_string(board.rows) +
                                " inner corners; expected 3 or more a side");
  if (picture.empty()) throw std::invalid_argument("the picture is empty");
  const cv::Mat gray(picture.height, picture.width, CV_8UC1, const_cast<std::uint8_t*>(picture.data),
                     static_cast<std::size_t>(picture.stride));
  std::vector<cv::Point2f> found;
  if (!find(gray, board, search, found) || static_cast<int>(found.size()) != board.corners()) return {};
  const int window = refinement_window(found, board);
  cv::cornerSubPix(gray, found, {window, window}, {-1, -1},
                   {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 40, 1e-3});
  BoardCorners corners;
  corners.reserve(found.size());
  for (const cv::Point2f& p : found) corners.emplace_back(p.x, p.y);
  return corners;
}

}  // namespace pavo
