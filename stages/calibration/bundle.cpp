#include "stages/calibration/bundle.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "types/lens.h"

namespace pavo {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr int kMostIterations = 100;

// R <- exp(w) R, t <- t + v: the first three numbers turn, the others move.
SE3 moved(const SE3& T, const Vector6& by) {
  const Eigen::Vector3d w = by.head<3>();
  const double angle = w.norm();
  if (angle == 0) return {T.R, T.t + by.tail<3>()};
  return {Eigen::AngleAxisd(angle, w / angle) * T.R, T.t + by.tail<3>()};
}

bool is_visible(const Camera& camera, const Eigen::Vector3d& p) {
  return camera.lens == Lens::equidistant ? p.norm() > 0 : p.z() > 0;
}

// Central differences of one corner's pixel by the camera's parameters and by the pose.
void differentiate(const Board& board, const Camera& camera, const SE3& T_c_b, int corner, Eigen::MatrixXd& by_camera,
                   Eigen::Matrix<double, 2, 6>& by_pose) {
  const Eigen::Vector3d point = board.point(corner), seen = T_c_b * point;
  for (int i = 0; i < by_camera.cols(); ++i) {
    Camera more = camera, less = camera;
    const double step = 1e-6 * std::max(1.0, std::abs(parameter(more, i)));
    parameter(more, i) += step;
    parameter(less, i) -= step;
    by_camera.col(i) = (project(more, seen) - project(less, seen)) / (2 * step);
  }
  for (int i = 0; i < 6; ++i) {
    const double step = i < 3 ? 1e-6 : 1e-6 * std::max(board.square_m, seen.norm());
    const Vector6 by = step * Vector6::Unit(i);
    by_pose.col(i) =
        (project(camera, moved(T_c_b, by) * point) - project(camera, moved(T_c_b, -by) * point)) / (2 * step);
  }
}

// J^T J and J^T r of one view, in the blocks that camera and pose make.
struct Normal {
  Eigen::MatrixXd camera, mixed;  // n x n, n x 6
  Eigen::VectorXd camera_gradient;
  Matrix6 pose;
  Vector6 pose_gradient;
};

Normal normal_equations(const Board& board, const Camera& camera, const BoardView& view, int parameters) {
  Normal normal{Eigen::MatrixXd::Zero(parameters, parameters), Eigen::MatrixXd::Zero(parameters, 6),
                Eigen::VectorXd::Zero(parameters), Matrix6::Zero(), Vector6::Zero()};
  Eigen::MatrixXd by_camera(2, parameters);
  Eigen::Matrix<double, 2, 6> by_pose;
  for (int i = 0; i < board.corners(); ++i) {
    differentiate(board, camera, view.T_c_b, i, by_camera, by_pose);
    const Eigen::Vector2d r =
        (*view.corners)[static_cast<std::size_t>(i)] - project(camera, view.T_c_b * board.point(i));
    normal.camera += by_camera.transpose() * by_camera;
    normal.mixed += by_camera.transpose() * by_pose;
    normal.pose += by_pose.transpose() * by_pose;
    normal.camera_gradient += by_camera.transpose() * r;
    normal.pose_gradient += by_pose.transpose() * r;
  }
  return normal;
}

Matrix6 damped(const Matrix6& m, double lambda) {
  Matrix6 d = m;
  d.diagonal() *= 1 + lambda;
  return d;
}

double total(const Board& board, const Camera& camera, std::span<const BoardView> views) {
  double sum = 0;
  for (const BoardView& view : views) sum += squared_error(board, camera, view);
  return sum;
}

// One step of the damped problem, the poses eliminated first (Schur). False where it cannot be solved.
bool step(const std::vector<Normal>& normals, double lambda, Camera& camera, std::span<BoardView> views) {
  const Eigen::Index n = normals.front().camera.rows();
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(n);
  for (const Normal& normal : normals) {
    Eigen::MatrixXd own = normal.camera;
    own.diagonal() *= 1 + lambda;
    const auto pose = damped(normal.pose, lambda).ldlt();
    S += own - normal.mixed * pose.solve(normal.mixed.transpose());
    g += normal.camera_gradient - normal.mixed * pose.solve(normal.pose_gradient);
  }
  const Eigen::VectorXd by = S.ldlt().solve(g);
  if (!by.allFinite()) return false;
  for (int i = 0; i < n; ++i) parameter(camera, i) += by(i);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Vector6 pose_by =
        damped(normals[v].pose, lambda).ldlt().solve(normals[v].pose_gradient - normals[v].mixed.transpose() * by);
    views[v].T_c_b = moved(views[v].T_c_b, pose_by);
  }
  return true;
}

Eigen::MatrixXd covariance_of(const std::vector<Normal>& normals, double squared_error, int corners) {
  const Eigen::Index n = normals.front().camera.rows();
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(n, n);
  for (const Normal& normal : normals)
    S += normal.camera - normal.mixed * normal.pose.ldlt().solve(normal.mixed.transpose());
  const auto views = static_cast<Eigen::Index>(normals.size());
  const auto freedom = static_cast<double>(2 * corners * views - n - 6 * views);
  const Eigen::VectorXd scale = S.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> solver(scale.asDiagonal() * S * scale.asDiagonal());
  if (freedom < 1 || !solver.isPositive() || solver.vectorD().minCoeff() < 1e-12) return {};
  const Eigen::MatrixXd inverse = solver.solve(Eigen::MatrixXd::Identity(n, n));
  return squared_error / freedom * (scale.asDiagonal() * inverse * scale.asDiagonal());
}

}  // namespace

int parameter_count(Lens lens) {
  return lens == Lens::radial_tangential ? 9 : lens == Lens::equidistant ? 8 : 4;
}

double& parameter(Camera& camera, int i) {
  double* const first[] = {&camera.fx, &camera.fy, &camera.cx, &camera.cy};
  return i < 4 ? *first[i] : camera.distortion[static_cast<std::size_t>(i - 4)];
}

double squared_error(const Board& board, const Camera& camera, const BoardView& view) {
  double sum = 0;
  for (int i = 0; i < board.corners(); ++i) {
    const Eigen::Vector3d p = view.T_c_b * board.point(i);
    if (!is_visible(camera, p)) return std::numeric_limits<double>::infinity();
    sum += ((*view.corners)[static_cast<std::size_t>(i)] - project(camera, p)).squaredNorm();
  }
  return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
}

BundleResult refine_calibration(const Board& board, Camera& camera, std::span<BoardView> views) {
  const int n = parameter_count(camera.lens);
  double error = total(board, camera, views), lambda = 1e-4;
  std::vector<Normal> normals;
  bool moved_since = true;
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    if (moved_since) {
      normals.clear();
      for (const BoardView& view : views) normals.push_back(normal_equations(board, camera, view, n));
    }
    Camera tried = camera;
    std::vector<BoardView> tried_views(views.begin(), views.end());
    const bool solved = step(normals, lambda, tried, tried_views);
    const double tried_error = solved ? total(board, tried, tried_views) : std::numeric_limits<double>::infinity();
    moved_since = tried_error < error;
    if (!moved_since) {
      lambda *= 10;
      if (lambda > 1e12) break;
      continue;
    }
    const double gain = (error - tried_error) / std::max(error, 1e-300);
    camera = tried;
    std::copy(tried_views.begin(), tried_views.end(), views.begin());
    error = tried_error;
    lambda = std::max(1e-12, lambda / 10);
    if (gain < 1e-10) break;
  }
  normals.clear();
  for (const BoardView& view : views) normals.push_back(normal_equations(board, camera, view, n));
  return {error, covariance_of(normals, error, board.corners())};
}

double refine_pose(const Board& board, const Camera& camera, BoardView& view) {
  double error = squared_error(board, camera, view), lambda = 1e-4;
  for (int iteration = 0; iteration < kMostIterations && lambda < 1e12; ++iteration) {
    const Normal normal = normal_equations(board, camera, view, 0);
    BoardView tried = view;
    tried.T_c_b = moved(view.T_c_b, damped(normal.pose, lambda).ldlt().solve(normal.pose_gradient));
    const double tried_error = squared_error(board, camera, tried);
    if (!(tried_error < error)) {
      lambda *= 10;
      continue;
    }
    const bool settled = error - tried_error < 1e-10 * error;
    view = tried;
    error = tried_error;
    lambda = std::max(1e-12, lambda / 10);
    if (settled) break;
  }
  return error;
}

}  // namespace pavo
