// From matches to the camera's motion between two frames: everything of the odometry that has no memory.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "stages/matches/matches.h"
#include "stages/pose/essential.h"
#include "stages/pose/pose_result.h"
#include "stages/pose/ransac.h"
#include "stages/pose/refine_motion.h"
#include "stages/pose/standstill.h"
#include "types/camera.h"
#include "types/pose.h"

namespace pavo {

struct RelativeMotionOptions {
  int min_matches = 20;  ///< fewer: nothing is estimated
  /// Consider that all may lie on one plane, where the eight-point has no answer. Off: the textbook's chain.
  bool planes = false;
  double plane_share = 0.9;  ///< of the eight-point's inliers that a plane must explain to be considered
  bool refine = true;        ///< five-parameter refinement behind the eight-point; off: the textbook's chain
  /// Motion beyond the rotation's that a match must show to be asked for the direction of t.
  double min_parallax_px = 0.5;
  double min_parallax_share = 0.05;  ///< of the inliers; fewer: the camera only turned
  RansacOptions ransac;
  RefineOptions refinement;
  StandstillOptions standstill;
};

struct RelativeMotion {
  bool found = false;
  Quality quality = Quality::coasting;  ///< tracked or standing, if found
  PoseReason reason = PoseReason::none;
  SE3 T_p_c{};  ///< the current camera's pose in the previous camera's frame; |t| = 1, standing: the identity
  int inliers = 0;
  int iterations = 0;  ///< of RANSAC
};

/// Stands still? Else RANSAC over the eight-point, F to E, the one of four motions with the points in front,
/// refinement. The same input gives the same output. One caller at a time (it owns the working memory); allocates only
/// where there are more pairs than ever before.
class RelativeMotionEstimator {
 public:
  /// Throws std::runtime_error where the camera's parameters are none.
  RelativeMotionEstimator(const Camera& camera, const RelativeMotionOptions& options);

  /// `is_inlier` is resized to one flag per pair.
  RelativeMotion operator()(std::span<const PointPair> pairs, Random random, std::vector<std::uint8_t>& is_inlier);

  /// Room for so many pairs: the calls that follow allocate nothing for fewer.
  void reserve(std::size_t pairs);

  /// The motion that a call before found, refined over more pairs: `pairs` are those it was called with and others
  /// behind them. `is_inlier` gets one flag for each.
  void refine_again(std::span<const PointPair> pairs, RelativeMotion& motion, std::vector<std::uint8_t>& is_inlier);

 private:
  RelativeMotion moving(std::span<const PointPair> pairs, Random random, std::vector<std::uint8_t>& is_inlier);
  InFront refined(std::span<const PointPair> pairs, const RansacResult& ransac, Random random,
                  std::span<const std::uint8_t> is_inlier);
  double refine_candidate(std::span<const PointPair> pairs, const Eigen::Matrix3d& F, SE3& T_c_p);
  void consider_plane(std::span<const PointPair> pairs, int inliers_of_F, Random random, double least, SE3& best);
  void select_inliers(std::span<const PointPair> pairs, const Eigen::Matrix3d& F);
  Eigen::Matrix3d fundamental_of(const SE3& T_c_p) const;
  int mark_inliers(const SE3& T_c_p, std::vector<std::uint8_t>& is_inlier) const;

  Camera camera_;
  RelativeMotionOptions options_;
  RansacScratch scratch_;
  std::vector<std::uint8_t> selected_, on_plane_;
  PointPairs inlier_pairs_;
  SampsonPoints inlier_points_;
};

}  // namespace pavo
