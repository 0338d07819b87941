#include "stages/map/bundle_adjustment.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

namespace pavo {
namespace {

// Two directions across the ray, along which its direction is moved.
struct Tangents {
  Eigen::Vector3d a, b;
};

Tangents tangents_of(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d d = direction.normalized();
  const Eigen::Vector3d a = d.unitOrthogonal();
  return {a, d.cross(a)};
}

constexpr double kNearest = 1e-3;  // scaled depth below which a point is not in front of the camera

double robust(double square, double scale) {
  return scale * scale * std::log1p(square / (scale * scale));
}

}  // namespace

double BundleAdjustment::cost(const Bundle& bundle) const {
  const Camera camera = refined_camera(camera_, bundle.lens);
  const LensError lens_off = bundle.lens - bundle.prior_lens;
  double sum = lens_off.dot(bundle.lens_information * lens_off);
  for (const BundlePoint& point : bundle.points) {
    const double off = point.ray.rho - point.prior_rho;
    sum += point.prior_information * off * off;
    for (int i = point.first; i < point.first + point.count; ++i) {
      const BundleObservation& z = bundle.observations[i];
      const Eigen::Vector3d p = scaled_in_camera(point.ray, bundle.poses[z.pose].T_w_c);
      if (p.z() < kNearest) {
        sum += robust(1e6, options_.loss_scale);
        continue;
      }
      const Eigen::Vector2d r = (pixel_of(camera, p) - Eigen::Vector2d(z.x, z.y)) * z.inverse_sigma;
      sum += robust(r.squaredNorm(), options_.loss_scale);
    }
  }
  return sum;
}

void BundleAdjustment::linearise(const Bundle& bundle) {
  poses_H_.setZero(size_, size_);
  poses_b_.setZero(size_);
  const Camera camera = refined_camera(camera_, bundle.lens);
  if (lens_ >= 0) {
    poses_H_.block<2, 2>(lens_, lens_) = bundle.lens_information;
    poses_b_.segment<2>(lens_) = bundle.lens_information * (bundle.lens - bundle.prior_lens);
  }
  for (std::size_t k = 0; k < bundle.points.size(); ++k) {
    const BundlePoint& point = bundle.points[k];
    const Tangents tangents = tangents_of(point.ray.direction);
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b(0, 0, point.prior_information * (point.ray.rho - point.prior_rho));
    H(2, 2) = point.prior_information;
    lens_cross_[k].setZero();
    for (int i = point.first; i < point.first + point.count; ++i) {
      const BundleObservation& z = bundle.observations[i];
      const SE3& T = bundle.poses[z.pose].T_w_c;
      const Eigen::Vector3d p = scaled_in_camera(point.ray, T);
      cross_[i].setZero();
      if (p.z() < kNearest) continue;
      const Eigen::Matrix<double, 2, 3> by_point = z.inverse_sigma * pixel_jacobian(camera, p);
      const Eigen::Vector2d r = (pixel_of(camera, p) - Eigen::Vector2d(z.x, z.y)) * z.inverse_sigma;
      const double weight = 1 / (1 + r.squaredNorm() / (options_.loss_scale * options_.loss_scale));
      Eigen::Matrix3d world;
      world << tangents.a, tangents.b, point.ray.origin - T.t;
      const Eigen::Matrix<double, 2, 3> J_point = by_point * (T.R.transpose() * world);
      const Eigen::Matrix<double, 3, 2> JtW = weight * J_point.transpose();
      H.noalias() += JtW * J_point;
      b.noalias() += JtW * r;
      const int column = column_[z.pose];
      const Eigen::Matrix2d J_lens = z.inverse_sigma * lens_jacobian(camera, p);
      if (lens_ >= 0) {
        const Eigen::Matrix2d JlW = weight * J_lens.transpose();
        poses_H_.block<2, 2>(lens_, lens_).noalias() += JlW * J_lens;
        poses_b_.segment<2>(lens_).noalias() += JlW * r;
        lens_cross_[k].noalias() += JlW * J_point;
      }
      if (column < 0) continue;
      const Eigen::Matrix<double, 2, 6> J_pose = pose_jacobian(by_point, p, point.ray.rho);
      const Eigen::Matrix<double, 6, 2> JpW = weight * J_pose.transpose();
      poses_H_.block<6, 6>(column, column).noalias() += JpW * J_pose;
      poses_b_.segment<6>(column).noalias() += JpW * r;
      cross_[i].noalias() = JpW * J_point;
      if (lens_ >= 0) poses_H_.block<6, 2>(column, lens_).noalias() += JpW * J_lens;
    }
    H_[k] = H;
    b_[k] = b;
  }
}

void BundleAdjustment::reduce(const Bundle& bundle, double damping) {
  reduced_ = poses_H_;
  for (int i = 0; i < size_; ++i) reduced_(i, i) += damping * poses_H_(i, i) + 1e-9;
  reduced_b_ = poses_b_;
  for (std::size_t k = 0; k < bundle.points.size(); ++k) {
    const BundlePoint& point = bundle.points[k];
    Eigen::Matrix3d H = H_[k];
    for (int i = 0; i < 3; ++i) H(i, i) += damping * H(i, i) + 1e-9;
    inverse_[k] = H.inverse();
    const int end = point.first + point.count;
    if (lens_ >= 0) {
      const Block23 weighted = lens_cross_[k] * inverse_[k];
      reduced_.block<2, 2>(lens_, lens_).noalias() -= weighted * lens_cross_[k].transpose();
      reduced_b_.segment<2>(lens_).noalias() -= weighted * b_[k];
    }
    for (int i = point.first; i < end; ++i) {
      const int row = column_[bundle.observations[i].pose];
      if (row < 0) continue;
      const Block63 weighted = cross_[i] * inverse_[k];
      reduced_b_.segment<6>(row).noalias() -= weighted * b_[k];
      if (lens_ >= 0) reduced_.block<6, 2>(row, lens_).noalias() -= weighted * lens_cross_[k].transpose();
      for (int j = i; j < end; ++j) {
        const int column = column_[bundle.observations[j].pose];
        if (column < 0) continue;
        const Matrix6d block = weighted * cross_[j].transpose();
        if (column >= row)
          reduced_.block<6, 6>(row, column) -= block;
        else
          reduced_.block<6, 6>(column, row) -= block.transpose();
      }
    }
  }
}

// bundle moved by minus the solution, back-substituted, into `out` (poses and points only).
void BundleAdjustment::step(const Bundle& bundle, const ReducedVector& dx, Bundle& out) const {
  for (std::size_t i = 0; i < out.poses.size(); ++i)
    if (column_[i] >= 0) out.poses[i].T_w_c = moved_by(out.poses[i].T_w_c, -dx.segment<6>(column_[i]));
  if (lens_ >= 0) out.lens -= dx.segment<2>(lens_);
  for (std::size_t k = 0; k < out.points.size(); ++k) {
    BundlePoint& point = out.points[k];
    Eigen::Vector3d b = b_[k];
    if (lens_ >= 0) b.noalias() -= lens_cross_[k].transpose() * dx.segment<2>(lens_);
    for (int i = point.first; i < point.first + point.count; ++i) {
      const int column = column_[bundle.observations[i].pose];
      if (column >= 0) b.noalias() -= cross_[i].transpose() * dx.segment<6>(column);
    }
    const Eigen::Vector3d delta = inverse_[k] * b;
    const Tangents tangents = tangents_of(point.ray.direction);
    point.ray.direction -= delta[0] * tangents.a + delta[1] * tangents.b;
    point.ray.rho -= delta[2];
  }
}

// The poses eliminated from the reduced system too.
Eigen::Matrix2d BundleAdjustment::marginal_of_lens() const {
  const Reduced poses = Reduced(reduced_.topLeftCorner(lens_, lens_)).selfadjointView<Eigen::Upper>();
  const Eigen::Matrix<double, Eigen::Dynamic, 2, 0, kMaxSize, 2> cross = reduced_.block(0, lens_, lens_, 2);
  return reduced_.block<2, 2>(lens_, lens_) - cross.transpose() * poses.ldlt().solve(cross);
}

BundleSummary BundleAdjustment::operator()(Bundle& bundle) {
  column_.assign(bundle.poses.size(), -1);
  size_ = 0;
  for (std::size_t i = 0; i < bundle.poses.size(); ++i) {
    if (bundle.poses[i].fixed) continue;
    column_[i] = size_;
    size_ += 6;
  }
  lens_ = bundle.lens_information.isZero(0) ? -1 : size_;
  if (lens_ >= 0) size_ += 2;
  if (size_ > kMaxSize) throw std::invalid_argument("bundle adjustment: too many free poses");
  cross_.resize(bundle.observations.size());
  lens_cross_.resize(bundle.points.size());
  H_.resize(bundle.points.size());
  inverse_.resize(bundle.points.size());
  b_.resize(bundle.points.size());

  BundleSummary summary;
  double damping = options_.initial_damping;
  double now = cost(bundle);
  summary.initial_cost = now;
  linearise(bundle);
  while (summary.iterations < options_.iterations) {
    ++summary.iterations;
    reduce(bundle, damping);
    const ReducedVector dx = reduced_.selfadjointView<Eigen::Upper>().ldlt().solve(reduced_b_);
    saved_poses_.assign(bundle.poses.begin(), bundle.poses.end());
    saved_points_.assign(bundle.points.begin(), bundle.points.end());
    saved_lens_ = bundle.lens;
    const bool finite = dx.allFinite();
    if (finite) step(bundle, dx, bundle);
    const double then = finite ? cost(bundle) : now;
    if (finite && then <= now) {
      const bool settled = now - then < options_.least_gain * now;
      now = then;
      damping = std::max(damping * 0.1, 1e-9);
      linearise(bundle);
      if (settled) break;
    } else {
      bundle.poses.swap(saved_poses_);
      bundle.points.swap(saved_points_);
      bundle.lens = saved_lens_;
      damping *= 100;
      if (damping > 1e4) break;
    }
  }
  summary.final_cost = now;
  if (lens_ >= 0) {
    reduce(bundle, 0);
    summary.lens_information = marginal_of_lens();
  }
  for (std::size_t k = 0; k < bundle.points.size(); ++k) {
    Eigen::Matrix3d H = H_[k];
    H.diagonal().array() += 1e-12;
    bundle.points[k].ray.sigma_rho = std::sqrt(std::max(H.inverse()(2, 2), 1e-16));
  }
  return summary;
}

}  // namespace pavo
