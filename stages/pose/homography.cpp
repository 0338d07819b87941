#include "stages/pose/homography.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace pavo {
namespace {

constexpr int kSample = 4, kMostSamples = 300, kLocalFits = 3;

struct RayPair {
  Eigen::Vector2d previous, current;
};

RayPair rays_of_pair(const PointPair& pair, const Camera& c) {
  return {.previous = {(pair.x_previous - c.cx) / c.fx, (pair.y_previous - c.cy) / c.fy},
          .current = {(pair.x_current - c.cx) / c.fx, (pair.y_current - c.cy) / c.fy}};
}

// Maps the projective basis (1,0,0), (0,1,0), (0,0,1), (1,1,1) to the four points.
Eigen::Matrix3d from_basis(const std::array<Eigen::Vector2d, kSample>& p) {
  Eigen::Matrix3d B;
  for (int i = 0; i < 3; ++i) B.col(i) = p[static_cast<std::size_t>(i)].homogeneous();
  const Eigen::Vector3d scale = B.inverse() * p[3].homogeneous();
  return B * scale.asDiagonal();
}

double squared_error(const Eigen::Matrix3d& H, const RayPair& pair) {
  const Eigen::Vector3d p = H * pair.previous.homogeneous();
  return p.z() > 0 ? (p.hnormalized() - pair.current).squaredNorm() : std::numeric_limits<double>::infinity();
}

// Least squares of the linear equations with H(2, 2) = 1, which it nearly is between rays of near views; each weighted
// by the depth that it was multiplied with.
Eigen::Matrix3d fit(std::span<const PointPair> pairs, const Camera& camera, std::span<const std::uint8_t> use,
                    const Eigen::Matrix3d& H) {
  Eigen::Matrix<double, 8, 8> A = Eigen::Matrix<double, 8, 8>::Zero();
  Eigen::Matrix<double, 8, 1> b = Eigen::Matrix<double, 8, 1>::Zero();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!use[i]) continue;
    const RayPair r = rays_of_pair(pairs[i], camera);
    const double depth = H.row(2) * r.previous.homogeneous(), w = 1 / (depth * depth);
    const double x = r.previous.x(), y = r.previous.y(), u = r.current.x(), v = r.current.y();
    Eigen::Matrix<double, 8, 2> J;
    J << x, 0, y, 0, 1, 0, 0, x, 0, y, 0, 1, -u * x, -v * x, -u * y, -v * y;
    A += w * J * J.transpose();
    b += w * J * r.current;
  }
  const Eigen::Matrix<double, 8, 1> h = A.ldlt().solve(b);
  Eigen::Matrix3d result;
  result << h(0), h(1), h(2), h(3), h(4), h(5), h(6), h(7), 1;
  return result;
}

}  // namespace

HomographyResult ransac_homography(std::span<const PointPair> pairs, const Camera& camera, const RansacOptions& options,
                                   Random random, std::vector<std::uint8_t>& is_inlier) {
  is_inlier.assign(pairs.size(), 0);
  HomographyResult result;
  if (pairs.size() < kSample) return result;
  const double tolerance = 2 * options.threshold_px / std::sqrt(camera.fx * camera.fy);
  const double worst = tolerance * tolerance;
  double least = std::numeric_limits<double>::infinity();
  const auto try_model = [&](const Eigen::Matrix3d& H) {
    if (!H.allFinite()) return false;
    double cost = 0;
    for (const PointPair& pair : pairs) {
      cost += std::min(squared_error(H, rays_of_pair(pair, camera)), worst);
      if (!(cost < least)) return false;
    }
    least = cost;
    result.H = H;
    result.inliers = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      is_inlier[i] = squared_error(H, rays_of_pair(pairs[i], camera)) < worst;
      result.inliers += is_inlier[i];
    }
    return true;
  };
  int needed = kMostSamples;
  for (int drawn = 0; drawn < needed; ++drawn) {
    std::array<Eigen::Vector2d, kSample> previous, current;
    for (std::size_t i = 0; i < kSample; ++i) {
      const RayPair r = rays_of_pair(pairs[random.below(static_cast<std::uint32_t>(pairs.size()))], camera);
      previous[i] = r.previous, current[i] = r.current;
    }
    Eigen::Matrix3d H = from_basis(current) * from_basis(previous).inverse();
    if (H(2, 2) < 0) H = -H;
    if (!try_model(H)) continue;
    for (int step = 0; step < kLocalFits && result.inliers >= 2 * kSample; ++step)
      if (!try_model(fit(pairs, camera, is_inlier, result.H))) break;
    const double clean = std::pow(static_cast<double>(result.inliers) / static_cast<double>(pairs.size()), kSample);
    if (clean >= options.confidence) break;
    const double enough = std::log1p(-options.confidence) / std::log1p(-clean);
    if (enough < needed) needed = static_cast<int>(std::ceil(enough));
  }
  result.found = result.inliers >= options.min_inliers;
  return result;
}

PlaneMotions motions_of_homography(const Eigen::Matrix3d& H_any) {
  // H' H has the eigenvalues s1^2 >= 1 >= s3^2 where H is scaled so that the middle one is 1.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> any(H_any.transpose() * H_any);
  Eigen::Matrix3d H = H_any / std::sqrt(any.eigenvalues()(1));
  if (H.determinant() < 0) H = -H;
  const Eigen::Vector3d squares = any.eigenvalues() / any.eigenvalues()(1);
  const double above = squares(2) - 1, below = 1 - squares(0);
  PlaneMotions motions;
  if (!(above + below > 1e-9)) return motions;
  const Eigen::Vector3d v1 = any.eigenvectors().col(2), v2 = any.eigenvectors().col(1), v3 = any.eigenvectors().col(0);
  for (const double sign : {1.0, -1.0}) {  // u and v2 span the directions that H does not stretch
    const Eigen::Vector3d u =
        (std::sqrt(std::max(below, 0.0)) * v1 + sign * std::sqrt(std::max(above, 0.0)) * v3) / std::sqrt(above + below);
    Eigen::Matrix3d U, W;
    U << v2, u, v2.cross(u);
    W << H * v2, H * u, (H * v2).cross(H * u);
    const Eigen::Matrix3d R = W * U.transpose();
    const Eigen::Vector3d t = (H - R) * v2.cross(u);
    if (!(t.norm() > 0)) continue;
    motions.T_c_p[static_cast<std::size_t>(motions.count++)] = {R, t.normalized()};
  }
  return motions;
}

}  // namespace pavo
