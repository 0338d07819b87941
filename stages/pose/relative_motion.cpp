#include "stages/pose/relative_motion.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

#include "stages/pose/essential.h"
#include "stages/pose/homography.h"

namespace pavo {
namespace {

void check(const Camera& camera) {
  const bool finite =
      std::isfinite(camera.fx) && std::isfinite(camera.fy) && std::isfinite(camera.cx) && std::isfinite(camera.cy);
  if (!finite || camera.fx <= 0 || camera.fy <= 0 || camera.width <= 0 || camera.height <= 0)
    throw std::runtime_error("camera: expected finite intrinsics, positive focal lengths and a positive image size");
}

constexpr double kAsGood = 1.05;            // costs within that are the same but for noise
constexpr double kClearlyFewer = 0.05;      // of the points behind a camera
constexpr double kClearlyLess_rad = 0.002;  // of turn

}  // namespace

RelativeMotionEstimator::RelativeMotionEstimator(const Camera& camera, const RelativeMotionOptions& options)
    : camera_(camera), options_(options) {
  check(camera);
}

RelativeMotion RelativeMotionEstimator::operator()(std::span<const PointPair> pairs, Random random,
                                                   std::vector<std::uint8_t>& is_inlier) {
  is_inlier.assign(pairs.size(), 0);
  if (pairs.size() < static_cast<std::size_t>(std::max(options_.min_matches, 8)))
    return {.reason = PoseReason::too_few_matches};
  if (stands_still(pairs, camera_, options_.standstill, is_inlier)) {
    return {.found = true,
            .quality = Quality::standing,
            .reason = PoseReason::standstill,
            .inliers = static_cast<int>(std::count(is_inlier.begin(), is_inlier.end(), std::uint8_t{1}))};
  }
  return moving(pairs, random, is_inlier);
}

RelativeMotion RelativeMotionEstimator::moving(std::span<const PointPair> pairs, Random random,
                                               std::vector<std::uint8_t>& is_inlier) {
  const RansacResult ransac = ransac_fundamental(pairs, options_.ransac, random, is_inlier, scratch_);
  RelativeMotion motion{.reason = PoseReason::too_few_inliers, .iterations = ransac.iterations};
  if (!ransac.found) return motion;

  InFront front = options_.refine ? refined(pairs, ransac, random, is_inlier)
                                  : motion_in_front(essential_from_fundamental(ransac.F, camera_), pairs, is_inlier,
                                                    camera_, options_.min_parallax_px);
  motion.inliers = mark_inliers(front.T_c_p, is_inlier);
  if (motion.inliers < options_.ransac.min_inliers) {
    std::fill(is_inlier.begin(), is_inlier.end(), std::uint8_t{0});
    motion.inliers = 0;
    return motion;
  }
  motion.found = true;
  motion.quality = Quality::tracked;
  const bool turned_only = front.asked < options_.min_parallax_share * motion.inliers;
  motion.reason = turned_only ? PoseReason::rotation_only : PoseReason::none;
  motion.T_p_c = front.T_c_p.inverse();
  return motion;
}

// Of each candidate's inliers: outliers make minima of their own, most of all where they lie near the epipole.
InFront RelativeMotionEstimator::refined(std::span<const PointPair> pairs, const RansacResult& ransac, Random random,
                                         std::span<const std::uint8_t> is_inlier) {
  SE3 best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < ransac.candidate_count; ++i) {
    SE3 T = motions_of(essential_from_fundamental(ransac.candidates[i], camera_))[0];
    const double cost = refine_candidate(pairs, ransac.candidates[i], T);
    if (cost < least) least = cost, best = T;
  }
  if (options_.planes) consider_plane(pairs, ransac.inliers, random, least, best);
  select_inliers(pairs, fundamental_of(best));
  refine_motion(inlier_points_, camera_, options_.refinement, best);
  return motion_in_front(essential_of(best), pairs, is_inlier, camera_, options_.min_parallax_px);
}

// Graduated: first a wide loss, then narrower ones (Blake and Zisserman, Visual Reconstruction, 1987). Returns the cost
// over all points.
double RelativeMotionEstimator::refine_candidate(std::span<const PointPair> pairs, const Eigen::Matrix3d& F, SE3& T) {
  select_inliers(pairs, F);
  for (const double factor : {4.0, 2.0, 1.0}) {
    RefineOptions options = options_.refinement;
    options.scale_px *= factor;
    if (factor > 1) options.max_iterations /= 2;
    refine_motion(inlier_points_, camera_, options, T);
  }
  RefineOptions only_cost = options_.refinement;
  only_cost.max_iterations = 0;
  return refine_motion(scratch_.points, camera_, only_cost, T);
}

// A plane's two motions fit equally well. One is often told by points that it would have behind a camera; where it is
// not (the camera moves towards the plane), the one that turns less is the likelier.
void RelativeMotionEstimator::consider_plane(std::span<const PointPair> pairs, int inliers_of_F, Random random,
                                             double least, SE3& best) {
  const HomographyResult plane = ransac_homography(pairs, camera_, options_.ransac, random, on_plane_);
  if (!plane.found || plane.inliers < options_.plane_share * inliers_of_F) return;
  const auto in_front = [&](const SE3& T) {
    return motion_in_front(essential_of(T), pairs, on_plane_, camera_, options_.min_parallax_px);
  };
  const auto behind = [](const InFront& f) { return 1 - static_cast<double>(f.in_front) / std::max(f.asked, 1); };
  const auto turn = [](const InFront& f) { return Eigen::AngleAxisd(f.T_c_p.R).angle(); };
  InFront chosen = in_front(best);
  const PlaneMotions motions = motions_of_homography(plane.H);
  for (int i = 0; i < motions.count; ++i) {
    SE3 T = motions.T_c_p[static_cast<std::size_t>(i)];
    if (!(refine_candidate(pairs, fundamental_of(T), T) < least * kAsGood)) continue;
    const InFront front = in_front(T);
    const double fewer = behind(chosen) - behind(front);
    if (std::abs(fewer) > kClearlyFewer ? fewer > 0 : turn(front) < turn(chosen) - kClearlyLess_rad) chosen = front;
  }
  best = chosen.T_c_p;
}

void RelativeMotionEstimator::reserve(std::size_t pairs) {
  scratch_.points.reserve(pairs);
  selected_.reserve(pairs);
  on_plane_.reserve(pairs);
  inlier_pairs_.reserve(pairs);
  inlier_points_.reserve(pairs);
}

void RelativeMotionEstimator::refine_again(std::span<const PointPair> pairs, RelativeMotion& motion,
                                           std::vector<std::uint8_t>& is_inlier) {
  SE3 T_c_p = motion.T_p_c.inverse();
  scratch_.points.assign(pairs);
  is_inlier.assign(pairs.size(), 0);
  select_inliers(pairs, fundamental_of(T_c_p));
  refine_motion(inlier_points_, camera_, options_.refinement, T_c_p);
  motion.inliers = mark_inliers(T_c_p, is_inlier);
  motion.T_p_c = T_c_p.inverse();
}

void RelativeMotionEstimator::select_inliers(std::span<const PointPair> pairs, const Eigen::Matrix3d& F) {
  selected_.resize(pairs.size());
  sampson_inliers(scratch_.points, sampson_model(F, scratch_.points),
                  static_cast<float>(2 * options_.ransac.threshold_px), selected_);
  inlier_pairs_.clear();
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (selected_[i]) inlier_pairs_.push_back(pairs[i]);
  inlier_points_.assign(inlier_pairs_);
}

Eigen::Matrix3d RelativeMotionEstimator::fundamental_of(const SE3& T_c_p) const {
  const Eigen::Matrix3d K_inverse = intrinsic_matrix(camera_).inverse();
  return K_inverse.transpose() * essential_of(T_c_p) * K_inverse;
}

int RelativeMotionEstimator::mark_inliers(const SE3& T_c_p, std::vector<std::uint8_t>& is_inlier) const {
  return sampson_inliers(scratch_.points, sampson_model(fundamental_of(T_c_p), scratch_.points),
                         static_cast<float>(options_.ransac.threshold_px), is_inlier);
}

}  // namespace pavo
