// From the corners of a chessboard in many pictures to the camera that took them: Zhang's method.
//
//   Zhang, A flexible new technique for camera calibration, PAMI 2000; the equidistant lens is Kannala and Brandt's,
//   PAMI 2006. The first guess is OpenCV's (cv::calibrateCamera), or for the fisheye the best of a few focal lengths;
//   the refinement and its covariance are those of bundle.h, on the very formulas that the undistortion uses.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "stages/calibration/board.h"
#include "types/camera.h"
#include "types/pose.h"

namespace pavo {

struct CalibratedView {
  bool used = true;   ///< false: dropped, its error is out of proportion
  double rms_px = 0;  ///< sqrt(mean |seen - projected|^2) over its corners; of a dropped one with its best pose
  SE3 T_c_b;          ///< board to camera
};

struct CalibrationResult {
  Camera camera;
  /// Standard deviations, in the same places: sigma.fx is that of camera.fx. 0 for what is not estimated.
  Camera sigma;
  double rms_px = 0;                  ///< over the views that are used
  double kept_out_rms_px = 0;         ///< of each view by a calibration without it and others (four parts in turn)
  double straightness_px = 0;         ///< median distance of a corner, undistorted, from the line of its row or column
  std::vector<CalibratedView> views;  ///< one for each that was given
  int used = 0;
};

inline constexpr int kFewestViews = 3;

/// `views`: corners from find_board(), in pictures of width x height. lens: radial_tangential (k1 k2 p1 p2 k3) or
/// equidistant. A view whose RMS is more than three times the median of all is dropped, as long as half of them are
/// left. Throws std::runtime_error with one line (why, and what to do) where there are fewer than kFewestViews, or
/// where they do not determine the camera: all from the same side, or fronto-parallel. Any thread; allocates.
CalibrationResult calibrate_camera(std::span<const BoardCorners> views, const Board& board, int width, int height,
                                   Lens lens);

}  // namespace pavo
