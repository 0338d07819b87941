// The last bit of accuracy: the motion of a calibrated camera has five parameters, not the seven of F.
#pragma once

#include "stages/pose/sampson.h"
#include "types/camera.h"
#include "types/pose.h"

namespace pavo {

struct RefineOptions {
  double scale_px = 0.5;    ///< of the robust loss (Geman and McClure's): residuals far beyond it count nothing
  int max_iterations = 10;  ///< each is one pass over the points
};

/// Minimises the robust sum of Sampson distances over R and the direction of t (Levenberg and Marquardt on SO(3) x S2),
/// over all points: outliers lose their weight by themselves. T_c_p maps points of the previous camera into the current
/// one; |t| = 1 on entry and exit. Returns the mean robust cost per point, in pixels squared, never more than it was on
/// entry. Pure; allocates nothing.
double refine_motion(const SampsonPoints& points, const Camera& camera, const RefineOptions& options, SE3& T_c_p);

}  // namespace pavo
