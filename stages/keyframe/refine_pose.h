// The camera's pose from points whose inverse depths are known more or less well, or not at all.
#pragma once

#include <Eigen/Core>
#include <span>

#include "stages/map/ray_point.h"
#include "stages/map/se3_step.h"
#include "types/camera.h"

namespace pavo {

/// A point and where it is seen. What rho's uncertainty does to the pixel is part of the error's covariance,
/// sigma_px^2 I + g g^T sigma_rho^2 with g = d pixel / d rho: a point of unknown depth only says on which epipolar line
/// it lies, one at infinity only how the camera turned, and all of them are in one least-squares problem.
struct PoseConstraint {
  RayPoint ray;
  Eigen::Vector2d pixel;
  double sigma_px = 0.5;
  double weight = 1;  ///< out: of the robust loss, 0 to 1
  double chi2 = 0;    ///< out: squared error in standard deviations; huge behind the camera
};

/// Where the camera is expected: a Gaussian about it, in its own frame.
struct PosePrior {
  SE3 T_w_c;
  Vector6d information = Vector6d::Zero();  ///< 1 / variance of x y z rx ry rz; 0: not known
};

struct RefinePoseOptions {
  double loss_scale = 2;  ///< of Geman and McClure's loss, in standard deviations; the last of the graduation
  double widest = 1;      ///< the first one's scale is so many times as large
  int iterations = 5;     ///< for each scale, at most
};

struct RefinedPose {
  SE3 T_w_c;
  Matrix6d information = Matrix6d::Zero();  ///< J^T W J, with the prior
  int inliers = 0;                          ///< within 3 standard deviations
  double cost = 0;                          ///< robust, per constraint
};

/// Iteratively reweighted Gauss-Newton with a damped step, the loss made narrower in powers of two (graduated
/// non-convexity: Blake and Zisserman, 1987). Pure but for the constraints' outputs; allocates nothing.
RefinedPose refine_pose(std::span<PoseConstraint> constraints, const Camera& camera, const PosePrior& prior,
                        const SE3& start, const RefinePoseOptions& options);

}  // namespace pavo
