// Where all that is seen lies on one plane (a floor below, a wall ahead), a continuum of fundamental matrices fits the
// matches. The plane's homography does not have that freedom, and leaves two motions to choose from.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "stages/matches/matches.h"
#include "stages/pose/random.h"
#include "stages/pose/ransac.h"
#include "types/camera.h"
#include "types/pose.h"

namespace pavo {

struct HomographyResult {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();  ///< ray_current ~ H ray_previous, rays (x/z, y/z, 1)
  int inliers = 0;
  bool found = false;
};

/// RANSAC over samples of four, least squares over the best one's inliers. An inlier is transferred to within twice
/// options.threshold_px. The same pairs, options and random stream give the same result. `is_inlier` is resized to one
/// flag per pair. Fewer than min_inliers: found is false. Pure but for the flags; allocates only for them.
HomographyResult ransac_homography(std::span<const PointPair> pairs, const Camera& camera, const RansacOptions& options,
                                   Random random, std::vector<std::uint8_t>& is_inlier);

/// The motions T_c_p that H ~ R + t m' allows for a plane m.X = 1 of the previous camera, |t| = 1, each without its
/// twin of opposite t and m (Ma, Soatto, Kosecka and Sastry, An Invitation to 3-D Vision, 2004, theorem 5.19). A
/// homography that is a rotation has none.
struct PlaneMotions {
  std::array<SE3, 2> T_c_p;
  int count = 0;
};
PlaneMotions motions_of_homography(const Eigen::Matrix3d& H);

}  // namespace pavo
