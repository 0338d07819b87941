// RANSAC over the normalised eight-point algorithm: the epipolar geometry that most matches agree with.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "stages/matches/matches.h"
#include "stages/pose/eight_point.h"
#include "stages/pose/random.h"
#include "stages/pose/sampson.h"

namespace pavo {

struct RansacOptions {
  double threshold_px = 1.0;  ///< Sampson distance up to which a match is an inlier
  double confidence = 0.999;  ///< of having drawn one sample without outliers
  int min_iterations = 100;   ///< drawn in any case: near-perfect matches end the search before it has looked around
  int max_iterations = 3000;
  int min_inliers = 15;  ///< fewer are no result
};

struct RansacResult {
  Eigen::Matrix3d F = Eigen::Matrix3d::Zero();  ///< x_current' F x_previous = 0, pixels; rank 2, Frobenius norm 1
  int inliers = 0;
  int iterations = 0;  ///< samples drawn
  bool found = false;
  /// The models that were the best one for a while, the latest first (candidates[0] = F): where F fits more noise than
  /// motion, an earlier one may lead to the better camera motion.
  static constexpr std::size_t kCandidates = 5;
  std::array<Eigen::Matrix3d, kCandidates> candidates{};
  std::size_t candidate_count = 0;
};

/// Working memory of the search. Grows to the largest number of matches seen; after that nothing is allocated.
struct RansacScratch {
  SampsonPoints points;
  std::vector<NormalisedPair> normalised;
};

/// Draws minimal samples until `confidence` is reached for the share of inliers seen so far, keeps the model with the
/// least truncated squared Sampson distance (MSAC: Torr and Zisserman, CVIU 2000), and improves each new best one by
/// least squares over its inliers (LO-RANSAC: Chum, Matas and Kittler, DAGM 2003).
/// The same pairs, options and random stream give the same result. `is_inlier` is resized to one flag per pair.
/// Fewer than 8 pairs, or no model with min_inliers: found is false and the flags are 0.
RansacResult ransac_fundamental(std::span<const PointPair> pairs, const RansacOptions& options, Random random,
                                std::vector<std::uint8_t>& is_inlier, RansacScratch& scratch);

}  // namespace pavo
