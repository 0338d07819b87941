// Which pose of an estimate is compared with which pose of the ground truth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "types/pose.h"

namespace pavo {

/// Two paths of the same number of poses: pose i of one belongs to pose i of the other.
struct PosePairs {
  std::vector<SE3> estimate;  ///< T_w_c in the estimate's own world
  std::vector<SE3> truth;     ///< T_w_c in the truth's own world
  bool by_time = false;
  std::int64_t largest_gap_ns = 0;  ///< between the two times of a pair
};

/// Poses farther apart in time than this are never a pair (as in the TUM benchmark's tools).
inline constexpr std::int64_t kLargestPairGap_ns = 20'000'000;

/// Where both have times: by time, each pose of the estimate with the nearest of the truth, one to one, at most
/// `largest_gap_ns` apart; poses without a partner are left out. Else by number, which needs as many poses in both.
/// Throws std::runtime_error, with the numbers in it, where that is impossible, fewer than two pairs are found, times
/// do not increase or a pose is not finite.
PosePairs associate(const Trajectory& estimate, const Trajectory& truth,
                    std::int64_t largest_gap_ns = kLargestPairGap_ns);

/// The path's length in metres.
double path_length_m(const std::vector<SE3>& T_w_c);

}  // namespace pavo
