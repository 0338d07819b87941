#include "stages/keyframe/pose_uncertainty.h"

namespace pavo {

PoseUncertainty::PoseUncertainty(const SystematicErrors& systematic, double focal_px) : systematic_(systematic) {
  const double direction = systematic.direction_px, turn = systematic.turn_px_per_m;
  per_m_ << direction, direction, direction, systematic.pitch_px_per_m, turn, turn;
  per_m_ /= focal_px;
}

// T_w_to = T_w_from T_from_to: the error there is seen from the new camera, Ad(T_to_from).
void PoseUncertainty::carry(const SE3& from, const SE3& to) {
  const Matrix6d Ad = adjoint(to.inverse() * from);
  drift_ = (Ad * drift_ * Ad.transpose()).eval();
  noise_ = (Ad * noise_ * Ad.transpose()).eval();
  by_way_ = (Ad * by_way_).eval();
  by_way_.diagonal().array() += (to.t - from.t).norm();
  scale_.travel(to.t - from.t);
}

void PoseUncertainty::step(const SE3& from, const SE3& to, const Matrix6d& drift, const Matrix6d& noise) {
  carry(from, to);
  drift_ += drift;
  noise_ = noise;
}

void PoseUncertainty::coast(const SE3& from, const SE3& to, const Matrix6d& guess) {
  carry(from, to);
  noise_ += guess;
}

void PoseUncertainty::begin_map() {
  drift_ += noise_;
  noise_.setZero();
}

void PoseUncertainty::take_over(const MapUpdate& update, double scale) {
  scale_.walk(update.scale_walk - walked_);
  walked_ = update.scale_walk;
  if (update.scale_variance >= 0) scale_.measured(update.scale_variance);
  scale_.rescale(scale);
}

Matrix6d PoseUncertainty::covariance(const SE3& T_w_c) const {
  const double of_all = systematic_.log_scale;
  const Matrix6d systematic = by_way_ * per_m_.asDiagonal();
  Matrix6d C = drift_ + noise_ + systematic * systematic.transpose();
  const Eigen::Vector3d way = T_w_c.R.transpose() * T_w_c.t;
  C.topLeftCorner<3, 3>() += of_all * of_all * way * way.transpose();
  C.topLeftCorner<3, 3>() += T_w_c.R.transpose() * scale_.position_variance * T_w_c.R;
  return 0.5 * (C + C.transpose());
}

}  // namespace pavo
