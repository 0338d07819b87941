#include "stages/pose/essential.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>
#include <cstddef>

namespace pavo {
namespace {

Eigen::Vector3d ray(double x, double y, const Camera& camera) {
  return {(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1.0};
}

InFront count_in_front(const SE3& T_c_p, std::span<const PointPair> pairs, std::span<const std::uint8_t> use,
                       const Camera& camera, double min_parallax_px) {
  InFront count{T_c_p};
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const PointPair& pair = pairs[i];
    if (!use[i] || parallax_px(T_c_p, pair, camera) < min_parallax_px) continue;
    const Depths depths = triangulate_depths(T_c_p, ray(pair.x_previous, pair.y_previous, camera),
                                             ray(pair.x_current, pair.y_current, camera));
    ++count.asked;
    count.in_front += depths.previous > 0 && depths.current > 0;
  }
  return count;
}

}  // namespace

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d intrinsic_matrix(const Camera& camera) {
  Eigen::Matrix3d K;
  K << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  return K;
}

Eigen::Matrix3d essential_from_fundamental(const Eigen::Matrix3d& F, const Camera& camera) {
  const Eigen::Matrix3d K = intrinsic_matrix(camera);
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(K.transpose() * F * K, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * Eigen::Vector3d(1, 1, 0).asDiagonal() * svd.matrixV().transpose();
}

Eigen::Matrix3d essential_of(const SE3& T_c_p) {
  return cross_matrix(T_c_p.t) * T_c_p.R;
}

std::array<SE3, 4> motions_of(const Eigen::Matrix3d& E) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(E, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU(), V = svd.matrixV();
  if (U.determinant() < 0) U.col(2) *= -1;
  if (V.determinant() < 0) V.col(2) *= -1;
  Eigen::Matrix3d W;
  W << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Matrix3d R1 = U * W * V.transpose(), R2 = U * W.transpose() * V.transpose();
  const Eigen::Vector3d t = U.col(2);
  return {SE3{R1, t}, SE3{R1, -t}, SE3{R2, t}, SE3{R2, -t}};
}

// [R ray_p, -ray_c] (d_p, d_c)^T = -t, by its normal equations.
Depths triangulate_depths(const SE3& T_c_p, const Eigen::Vector3d& ray_p, const Eigen::Vector3d& ray_c) {
  const Eigen::Vector3d a = T_c_p.R * ray_p;
  const double aa = a.squaredNorm(), cc = ray_c.squaredNorm(), ac = a.dot(ray_c);
  const double at = a.dot(T_c_p.t), ct = ray_c.dot(T_c_p.t);
  const double determinant = aa * cc - ac * ac;
  return {(ac * ct - cc * at) / determinant, (aa * ct - ac * at) / determinant};
}

double parallax_px(const SE3& T_c_p, const PointPair& pair, const Camera& camera) {
  const Eigen::Vector3d rotated = T_c_p.R * ray(pair.x_previous, pair.y_previous, camera);
  if (rotated.z() <= 0) return std::hypot(camera.width, camera.height);  // turned out of the picture
  return std::hypot(camera.fx * rotated.x() / rotated.z() + camera.cx - pair.x_current,
                    camera.fy * rotated.y() / rotated.z() + camera.cy - pair.y_current);
}

// Fewest contradictions first: of the two rotations, the false one makes nearly every point move a lot.
InFront motion_in_front(const Eigen::Matrix3d& E, std::span<const PointPair> pairs, std::span<const std::uint8_t> use,
                        const Camera& camera, double min_parallax_px) {
  constexpr int kEnough = 8;
  const std::array<SE3, 4> candidates = motions_of(E);
  InFront best;
  bool have_best = false;
  for (const SE3& candidate : candidates) {
    const InFront count = count_in_front(candidate, pairs, use, camera, min_parallax_px);
    const int against = count.asked - count.in_front, against_best = best.asked - best.in_front;
    if (!have_best || against < against_best || (against == against_best && count.in_front > best.in_front))
      best = count;
    have_best = true;
  }
  if (best.in_front >= kEnough) return best;
  const SE3 opposite{best.T_c_p.R, -best.T_c_p.t};  // too few that could tell it from this one: ask all
  if (count_in_front(opposite, pairs, use, camera, 0).in_front >
      count_in_front(best.T_c_p, pairs, use, camera, 0).in_front)
    best = count_in_front(opposite, pairs, use, camera, min_parallax_px);
  return best;
}

}  // namespace pavo
