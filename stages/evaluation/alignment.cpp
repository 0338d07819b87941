#include "stages/evaluation/alignment.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace pavo {
namespace {

constexpr double kStandstill_m = 1e-9;  ///< a root mean square deviation below it is no path

/// The first poses coincide: G_0 S E_0^-1 with the scaling S.
Similarity align_first_poses(const PosePairs& pairs, double scale) {
  const SE3& e = pairs.estimate.front();
  const SE3& g = pairs.truth.front();
  Similarity similarity;
  similarity.scale = scale;
  similarity.R = g.R * e.R.transpose();
  similarity.t = g.t - scale * (similarity.R * e.t);
  return similarity;
}

Similarity align_scale(const PosePairs& pairs) {
  const SE3 T_e = pairs.estimate.front().inverse();
  const SE3 T_g = pairs.truth.front().inverse();
  double eg = 0, ee = 0, gg = 0;
  for (std::size_t i = 0; i < pairs.truth.size(); ++i) {
    const Eigen::Vector3d e = T_e * pairs.estimate[i].t;
    const Eigen::Vector3d g = T_g * pairs.truth[i].t;
    eg += e.dot(g);
    ee += e.squaredNorm();
    gg += g.squaredNorm();
  }
  const double still = static_cast<double>(pairs.truth.size()) * kStandstill_m * kStandstill_m;
  const bool known = ee > still && gg > still && eg > 0;
  Similarity similarity = align_first_poses(pairs, known ? eg / ee : 1);
  similarity.scale_known = known;
  return similarity;
}

/// From the first position on: a path that stands still far from the origin has no rounding that looks like motion.
Eigen::Vector3d mean_position(const std::vector<SE3>& T_w_c) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const SE3& pose : T_w_c) sum += pose.t - T_w_c.front().t;
  return T_w_c.front().t + sum / static_cast<double>(T_w_c.size());
}

Similarity umeyama(const PosePairs& pairs, bool with_scale) {
  const double n = static_cast<double>(pairs.truth.size());
  const Eigen::Vector3d mean_e = mean_position(pairs.estimate);
  const Eigen::Vector3d mean_g = mean_position(pairs.truth);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double variance_e = 0, variance_g = 0;
  for (std::size_t i = 0; i < pairs.truth.size(); ++i) {
    const Eigen::Vector3d e = pairs.estimate[i].t - mean_e;
    const Eigen::Vector3d g = pairs.truth[i].t - mean_g;
    covariance += g * e.transpose() / n;
    variance_e += e.squaredNorm() / n;
    variance_g += g.squaredNorm() / n;
  }
  Similarity similarity;
  if (std::min(variance_e, variance_g) > kStandstill_m * kStandstill_m) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d sign = Eigen::Vector3d::Ones();
    if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign.z() = -1;
    similarity.R = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
    const double scale = svd.singularValues().dot(sign) / variance_e;
    similarity.scale_known = with_scale && scale > 0;
    if (similarity.scale_known) similarity.scale = scale;
  } else {
    similarity.R = pairs.truth.front().R * pairs.estimate.front().R.transpose();
  }
  similarity.t = mean_g - similarity.scale * (similarity.R * mean_e);
  return similarity;
}

}  // namespace

Similarity align(const PosePairs& pairs, Alignment alignment) {
  if (pairs.truth.empty() || pairs.truth.size() != pairs.estimate.size())
    throw std::invalid_argument("alignment needs one pair of poses or more");
  switch (alignment) {
    case Alignment::none:
      return align_first_poses(pairs, 1);
    case Alignment::scale:
      return align_scale(pairs);
    case Alignment::se3:
      return umeyama(pairs, false);
    case Alignment::sim3:
      return umeyama(pairs, true);
  }
  throw std::invalid_argument("no such alignment");
}

Trajectory transformed(const Similarity& similarity, const Trajectory& trajectory) {
  Trajectory result = trajectory;
  for (SE3& T_w_c : result.T_w_c) T_w_c = similarity * T_w_c;
  return result;
}

}  // namespace pavo
