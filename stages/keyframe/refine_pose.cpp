#include "stages/keyframe/refine_pose.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/keyframe/refine_pose.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef PAVO_REFINE_POSE_VIEW
#define PAVO_REFINE_POSE_VIEW  // this part is read once, the kernels below once per SIMD target
namespace pavo {

constexpr int kParameters = 6;
constexpr int kSums = kParameters * (kParameters + 1) / 2 + kParameters + 1;  // J^T W J, J^T W r, cost

/// From where the points are looked at, and through what.
struct PoseView {
  double R[3][3], t[3];  // T_world_camera
  double fx, fy, cx, cy, k1;
  double scale2;  // of the loss, squared
};

}  // namespace pavo
#endif

HWY_BEFORE_NAMESPACE();
namespace pavo {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, PoseConstraints::kLanes>;
using V = hn::Vec<D>;

struct Point {
  V x, y, z;
};

HWY_INLINE V dot(V ax, V ay, V bx, V by) {
  return hn::MulAdd(ax, bx, hn::Mul(ay, by));
}

// R^T p
HWY_INLINE Point turned_back(const PoseView& view, const Point& p) {
  const D d;
  const auto along = [&](int axis) HWY_ATTR {
    return hn::MulAdd(hn::Set(d, view.R[0][axis]), p.x,
                      dot(hn::Set(d, view.R[1][axis]), hn::Set(d, view.R[2][axis]), p.y, p.z));
  };
  return {along(0), along(1), along(2)};
}

// pixel_of(), less the pixel where the point was found, and pixel_jacobian(); p.z > 0.
struct Projection {
  V u, v;            // residual
  V by_point[2][3];  // its derivative
};

HWY_INLINE Projection project(const PoseView& view, const Point& p, V found_u, V found_v) {
  const D d;
  const V one = hn::Set(d, 1.0), fx = hn::Set(d, view.fx), fy = hn::Set(d, view.fy), k = hn::Set(d, view.k1);
  const V inverse_z = hn::Div(one, p.z), x = hn::Mul(p.x, inverse_z), y = hn::Mul(p.y, inverse_z);
  const V s = hn::MulAdd(k, hn::Min(dot(x, y, x, y), hn::Set(d, kWidestRadius2)), one);
  const V kx = hn::Mul(hn::Add(k, k), x), ky = hn::Mul(hn::Add(k, k), y);
  const V xx = hn::MulAdd(kx, x, s), xy = hn::Mul(kx, y), yy = hn::MulAdd(ky, y, s);
  const V fx_z = hn::Mul(fx, inverse_z), fy_z = hn::Mul(fy, inverse_z);
  return {hn::MulAdd(hn::Mul(fx, s), x, hn::Sub(hn::Set(d, view.cx), found_u)),
          hn::MulAdd(hn::Mul(fy, s), y, hn::Sub(hn::Set(d, view.cy), found_v)),
          {{hn::Mul(fx_z, xx), hn::Mul(fx_z, xy), hn::Neg(hn::Mul(fx_z, dot(xx, xy, x, y)))},
           {hn::Mul(fy_z, xy), hn::Mul(fy_z, yy), hn::Neg(hn::Mul(fy_z, dot(xy, yy, x, y)))}}};
}

// Adds what the points of the lanes from `lane` on say to the sums.
HWY_INLINE void add_points(PoseConstraints::Block& block, std::size_t lane, const PoseView& view, V* sums) {
  const D d;
  const auto load = [&](const double* numbers) HWY_ATTR { return hn::Load(d, numbers + lane); };
  const V one = hn::Set(d, 1.0), scale2 = hn::Set(d, view.scale2), rho = load(block.rho);
  const Point by_rho = turned_back(view, {hn::Sub(load(block.origin[0]), hn::Set(d, view.t[0])),
                                          hn::Sub(load(block.origin[1]), hn::Set(d, view.t[1])),
                                          hn::Sub(load(block.origin[2]), hn::Set(d, view.t[2]))});
  const Point direction =
      turned_back(view, {load(block.direction[0]), load(block.direction[1]), load(block.direction[2])});
  Point p{hn::MulAdd(rho, by_rho.x, direction.x), hn::MulAdd(rho, by_rho.y, direction.y),
          hn::MulAdd(rho, by_rho.z, direction.z)};
  const auto behind = hn::Lt(p.z, hn::Set(d, 1e-3));
  p.z = hn::IfThenElse(behind, one, p.z);
  const Projection at = project(view, p, load(block.pixel[0]), load(block.pixel[1]));
  const auto& by = at.by_point;

  // S^-1 = (I - c g g^T) / sigma_px^2, c = q / (1 + q g^T g), q = sigma_rho^2 / sigma_px^2 (Sherman and Morrison).
  const V information = load(block.information), q = hn::Mul(load(block.rho_variance), information);
  const V gu = hn::MulAdd(by[0][0], by_rho.x, dot(by[0][1], by[0][2], by_rho.y, by_rho.z));
  const V gv = hn::MulAdd(by[1][0], by_rho.x, dot(by[1][1], by[1][2], by_rho.y, by_rho.z));
  const V c = hn::Div(q, hn::MulAdd(q, dot(gu, gv, gu, gv), one));
  const V known = hn::Mul(c, dot(gu, gv, at.u, at.v));
  const V Sru = hn::Mul(information, hn::NegMulAdd(known, gu, at.u));
  const V Srv = hn::Mul(information, hn::NegMulAdd(known, gv, at.v));
  const V chi2 = dot(at.u, at.v, Sru, Srv);

  // chi2 / (1 + chi2 / scale^2), so that the weight of chi2 is 1 / (1 + chi2 / scale^2)^2.
  const V shrink = hn::Div(scale2, hn::Add(scale2, chi2));
  const V weight = hn::IfThenZeroElse(behind, hn::Mul(shrink, shrink));
  const auto lost = hn::And(behind, hn::Gt(information, hn::Zero(d)));
  const V cost = hn::IfThenElse(behind, hn::IfThenElseZero(lost, scale2), hn::Mul(chi2, shrink));
  hn::Store(hn::IfThenElse(behind, hn::Set(d, 1e9), chi2), d, block.chi2 + lane);

  // pose_jacobian()
  V J[2][kParameters], SJ[2][kParameters];
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < 3; ++k) J[i][k] = hn::Neg(hn::Mul(rho, by[i][k]));
    J[i][3] = hn::MulSub(by[i][1], p.z, hn::Mul(by[i][2], p.y));
    J[i][4] = hn::MulSub(by[i][2], p.x, hn::Mul(by[i][0], p.z));
    J[i][5] = hn::MulSub(by[i][0], p.y, hn::Mul(by[i][1], p.x));
  }
  const V weighed = hn::Mul(weight, information);
  for (int k = 0; k < kParameters; ++k) {
    const V along = hn::Mul(c, dot(gu, gv, J[0][k], J[1][k]));
    SJ[0][k] = hn::Mul(weighed, hn::NegMulAdd(along, gu, J[0][k]));
    SJ[1][k] = hn::Mul(weighed, hn::NegMulAdd(along, gv, J[1][k]));
  }
  int s = 0;
  for (int k = 0; k < kParameters; ++k)
    for (int m = k; m < kParameters; ++m, ++s)
      sums[s] = hn::MulAdd(J[0][k], SJ[0][m], hn::MulAdd(J[1][k], SJ[1][m], sums[s]));
  for (int k = 0; k < kParameters; ++k, ++s) sums[s] = hn::MulAdd(SJ[0][k], at.u, hn::MulAdd(SJ[1][k], at.v, sums[s]));
  sums[s] = hn::Add(sums[s], cost);
}

void Accumulate(std::span<PoseConstraints::Block> blocks, const PoseView& view, double* totals) {
  const D d;
  V sums[kSums];
  for (V& sum : sums) sum = hn::Zero(d);
  for (PoseConstraints::Block& block : blocks)
    for (std::size_t lane = 0; lane < PoseConstraints::kLanes; lane += hn::Lanes(d))
      add_points(block, lane, view, sums);
  for (int s = 0; s < kSums; ++s) totals[s] = hn::GetLane(hn::SumOfLanes(d, sums[s]));
}

}  // namespace HWY_NAMESPACE
}  // namespace pavo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pavo {

HWY_EXPORT(Accumulate);

namespace {

struct Normal {
  Matrix6d A;
  Vector6d b;
  double cost = 0;
};

Normal linearise(PoseConstraints& constraints, const Camera& camera, const PosePrior& prior, const SE3& T,
                 double scale) {
  PoseView view{.R = {},
                .t = {T.t.x(), T.t.y(), T.t.z()},
                .fx = camera.fx,
                .fy = camera.fy,
                .cx = camera.cx,
                .cy = camera.cy,
                .k1 = camera.distortion[0],
                .scale2 = scale * scale};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) view.R[i][k] = T.R(i, k);
  std::array<double, kSums> sums;
  HWY_DYNAMIC_DISPATCH(Accumulate)(constraints.blocks(), view, sums.data());
  Normal n;
  const double* in = sums.data();
  for (int i = 0; i < kParameters; ++i)
    for (int k = i; k < kParameters; ++k) n.A(i, k) = n.A(k, i) = *in++;
  for (int i = 0; i < kParameters; ++i) n.b(i) = *in++;
  n.cost = *in;
  const Vector6d off = step_between(prior.T_w_c, T);
  n.A.diagonal() += prior.information;
  n.b += prior.information.cwiseProduct(off);
  n.cost += off.dot(prior.information.cwiseProduct(off));
  return n;
}

}  // namespace

RefinedPose refine_pose(PoseConstraints& constraints, const Camera& camera, const PosePrior& prior, const SE3& start,
                        const RefinePoseOptions& options) {
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
  for (std::size_t i = 0; i < constraints.size(); ++i) result.inliers += constraints.chi2(i) < 9;
  return result;
}

}  // namespace pavo
#endif  // HWY_ONCE
