// The camera and the poses of the board that bring the corners nearest to where they were seen: least squares over all
// of them at once (Zhang, PAMI 2000, section 3.2), and how sure the result is.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "stages/calibration/board.h"
#include "types/camera.h"
#include "types/pose.h"

namespace pavo {

/// One picture of the board: its corners, and T_c_b (board to camera).
struct BoardView {
  const BoardCorners* corners = nullptr;
  SE3 T_c_b;
};

/// The parameters that are estimated: fx, fy, cx, cy and then k1 k2 p1 p2 k3 (radial-tangential) or k1 ... k4
/// (equidistant).
int parameter_count(Lens lens);
double& parameter(Camera& camera, int i);

struct BundleResult {
  double squared_error = 0;    ///< summed over all corners of all views, pixels^2
  Eigen::MatrixXd covariance;  ///< of the parameters: sigma^2 S^-1 with the Schur complement S of the poses; empty
                               ///< where the views do not determine them
};

/// Levenberg and Marquardt over the camera and all poses, from the values given. Any thread; allocates.
BundleResult refine_calibration(const Board& board, Camera& camera, std::span<BoardView> views);

/// The same over the pose of one view, with the camera as it is. Returns the squared error.
double refine_pose(const Board& board, const Camera& camera, BoardView& view);

/// Summed over the view's corners, pixels^2; infinite where a corner is behind the camera.
double squared_error(const Board& board, const Camera& camera, const BoardView& view);

}  // namespace pavo
