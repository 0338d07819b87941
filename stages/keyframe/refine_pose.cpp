#include "stages/keyframe/refine_pose.h"

#include <Eigen/Cholesky>

namespace pavo {
namespace {

struct Normal {
  Matrix6d A = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  double cost = 0;
};

// S^-1 = (I - g g^T / (r + g^T g)) / sigma^2, r = sigma^2 / sigma_rho^2 (Sherman and Morrison).
Eigen::Matrix2d information_of(const Eigen::Vector2d& g, double sigma_px, double sigma_rho) {
  const double variance = sigma_px * sigma_px;
  const double ratio = variance / (sigma_rho * sigma_rho);
  return (Eigen::Matrix2d::Identity() - g * g.transpose() / (ratio + g.squaredNorm())) / variance;
}

Normal linearise(std::span<PoseConstraint> constraints, const Camera& camera, const PosePrior& prior, const SE3& T,
                 double scale) {
  Normal n;
  const double scale2 = scale * scale;
  for (PoseConstraint& c : constraints) {
    const Eigen::Vector3d by_rho = T.R.transpose() * (c.ray.origin - T.t);
    const Eigen::Vector3d p = T.R.transpose() * c.ray.direction + c.ray.rho * by_rho;
    if (p.z() < 1e-3) {
      c.weight = 0, c.chi2 = 1e9, n.cost += scale2;
      continue;
    }
    const Eigen::Matrix<double, 2, 3> by_point = pixel_jacobian(camera, p);
    const Eigen::Vector2d r = pixel_of(camera, p) - c.pixel;
    const Eigen::Matrix2d S = information_of(by_point * by_rho, c.sigma_px, c.ray.sigma_rho);
    const Eigen::Vector2d Sr = S * r;
    c.chi2 = r.dot(Sr);
    const double shrink = 1 / (1 + c.chi2 / scale2);
    c.weight = shrink * shrink;
    n.cost += c.chi2 * shrink;
    const Eigen::Matrix<double, 2, 6> J = pose_jacobian(by_point, p, c.ray.rho);
    const Eigen::Matrix<double, 2, 6> SJ = c.weight * (S * J);
    n.A.noalias() += J.transpose() * SJ;
    n.b.noalias() += J.transpose() * (c.weight * Sr);
  }
  const Vector6d off = step_between(prior.T_w_c, T);
  n.A.diagonal() += prior.information;
  n.b += prior.information.cwiseProduct(off);
  n.cost += off.dot(prior.information.cwiseProduct(off));
  return n;
}

}  // namespace

RefinedPose refine_pose(std::span<PoseConstraint> constraints, const Camera& camera, const PosePrior& prior,
                        const SE3& start, const RefinePoseOptions& options) {
  RefinedPose result;
  result.T_w_c = start;
  // NOLINTNEXTLINE(clang-analyzer-security.FloatLoopCounter): halving is exact
  for (double factor = options.widest; factor >= 1; factor /= 2) {
    const double scale = options.loss_scale * factor;
    Normal at = linearise(constraints, camera, prior, result.T_w_c, scale);
    double damping = 1e-6;
    bool accepted = true;
    for (int i = 0; i < options.iterations; ++i) {
      Matrix6d A = at.A;
      A.diagonal() *= 1 + damping;
      A.diagonal().array() += 1e-9;
      const Vector6d step = -A.ldlt().solve(at.b);
      if (!step.allFinite()) break;
      const SE3 candidate = moved_by(result.T_w_c, step);
      const Normal there = linearise(constraints, camera, prior, candidate, scale);
      accepted = there.cost <= at.cost;
      if (accepted) {
        const bool settled = at.cost - there.cost <= 1e-3 * at.cost;
        result.T_w_c = candidate;
        at = there;
        damping *= 0.1;
        if (settled) break;
      } else {
        damping = damping * 100 + 1e-4;
        if (damping > 1e4) break;
      }
    }
    if (factor < 2) {
      if (!accepted) at = linearise(constraints, camera, prior, result.T_w_c, scale);  // the weights of this pose
      result.information = at.A;
      result.cost = at.cost / static_cast<double>(std::max<std::size_t>(1, constraints.size()));
    }
  }
  for (const PoseConstraint& c : constraints) result.inliers += c.chi2 < 9;
  return result;
}

}  // namespace pavo
