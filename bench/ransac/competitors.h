#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "stages/matches/matches.h"
#include "stages/pose/ransac.h"

namespace pavo::bench {

struct Problem {
  PointPairs pairs;
  std::uint64_t seed = 0;
  RansacScratch scratch;
};

struct Solution {
  Eigen::Matrix3d F;  ///< x_current' F x_previous = 0, pixels
  std::vector<std::uint8_t> is_inlier;
  int iterations = 0;  ///< 0: not told
};

inline constexpr double kThresholdPx = 1.0, kConfidence = 0.999;

void ransac_pavo(Problem& problem, Solution& solution);
void ransac_opencv(Problem& problem, Solution& solution);

}  // namespace pavo::bench
