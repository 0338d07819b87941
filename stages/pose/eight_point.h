// The normalised eight-point algorithm (Hartley, "In Defense of the Eight-Point Algorithm", PAMI 1997).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

#include "stages/matches/matches.h"

namespace pavo {

/// x_n = scale (x - (cx, cy)): centroid at 0, root mean square distance from it sqrt(2).
struct Normalisation {
  double scale = 1, cx = 0, cy = 0;
  Eigen::Matrix3d matrix() const;
};

/// Of both images' points. Identical points get the scale 1.
struct PairNormalisation {
  Normalisation previous, current;
};
PairNormalisation normalisation_of(std::span<const PointPair> pairs);

/// The four coordinates of a pair, normalised: x, y of the previous image, x', y' of the current one.
using NormalisedPair = std::array<double, 4>;
NormalisedPair normalised(const PointPair& pair, const PairNormalisation& by);

/// The F with x'^T F x = 0 for exactly eight pairs: the null vector of their 8 x 9 system, by Gauss elimination.
/// Rank 2 is not enforced. False where the system has a larger null space (a degenerate sample).
bool eight_point_minimal(std::span<const NormalisedPair, 8> sample, Eigen::Matrix3d& F);

/// The sum over pairs of the outer products of the rows of that system: least squares for any number of pairs.
class EightPointSystem {
 public:
  void add(const NormalisedPair& pair, double weight);
  /// The F of unit norm with the least weighted sum of squares. Rank 2 is not enforced.
  Eigen::Matrix3d solve() const;

 private:
  std::array<double, 45> upper_{};  // of the symmetric 9 x 9 matrix, row by row
};

/// The nearest matrix of rank 2 in the Frobenius norm.
Eigen::Matrix3d nearest_rank2(const Eigen::Matrix3d& F);

/// The same up to rounding where F is close to rank 2, by inverse iteration for its smallest singular vector instead of
/// an SVD: 20 times cheaper, for the thousands of samples that are only looked at once.
Eigen::Matrix3d rank2_by_iteration(const Eigen::Matrix3d& F);

/// The whole algorithm: normalise, least squares, rank 2, back to pixels; F of unit norm with x_c' F x_p = 0.
/// Needs at least 8 pairs (else std::invalid_argument). Pure; allocates nothing.
Eigen::Matrix3d eight_point(std::span<const PointPair> pairs);

/// F between normalised points becomes F between pixels, of unit norm.
Eigen::Matrix3d denormalised(const Eigen::Matrix3d& F, const PairNormalisation& by);

}  // namespace pavo
