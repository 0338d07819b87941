// The camera's pose from points whose inverse depths are known more or less well, or not at all.
#pragma once

#include <Eigen/Core>

#include "stages/keyframe/pose_constraints.h"
#include "stages/map/se3_step.h"
#include "types/camera.h"

namespace pavo {

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
/// non-convexity: Blake and Zisserman, 1987). Pure but for the constraints' chi2; allocates nothing.
RefinedPose refine_pose(PoseConstraints& constraints, const Camera& camera, const PosePrior& prior, const SE3& start,
                        const RefinePoseOptions& options);

}  // namespace pavo
