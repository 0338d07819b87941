#include "stages/pose/refine_motion.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstddef>

#include "stages/pose/essential.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/pose/refine_motion.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef PAVO_REFINE_MOTION_NORMAL_EQUATIONS
#define PAVO_REFINE_MOTION_NORMAL_EQUATIONS  // this part is read once, the kernels below once per SIMD target
namespace pavo {

constexpr int kParameters = 5;  // a rotation vector, two tangents of the sphere of directions
constexpr int kSums = kParameters * (kParameters + 1) / 2 + kParameters + 1;  // J^T W J, J^T W r, cost

/// F and its derivatives by the parameters, between centred pixels; row-major.
struct LinearisedModel {
  float f[9];
  float df[kParameters][9];
  float inverse_scale2;  // of the loss
};

}  // namespace pavo
#endif

HWY_BEFORE_NAMESPACE();
namespace pavo {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<float>;
using V = hn::Vec<D>;

struct Lines {
  V a, b, c;  // F x
  V p, q;     // F^T x', its first two
};

HWY_INLINE Lines lines_of(const float* f, V x, V y, V u, V v) {
  const D d;
  const V f0 = hn::Set(d, f[0]), f1 = hn::Set(d, f[1]), f3 = hn::Set(d, f[3]), f4 = hn::Set(d, f[4]);
  return {
      hn::MulAdd(f0, x, hn::MulAdd(f1, y, hn::Set(d, f[2]))), hn::MulAdd(f3, x, hn::MulAdd(f4, y, hn::Set(d, f[5]))),
      hn::MulAdd(hn::Set(d, f[6]), x, hn::MulAdd(hn::Set(d, f[7]), y, hn::Set(d, f[8]))),
      hn::MulAdd(f0, u, hn::MulAdd(f3, v, hn::Set(d, f[6]))), hn::MulAdd(f1, u, hn::MulAdd(f4, v, hn::Set(d, f[7])))};
}

// Adds what the points i, i + 1, ... (the first `count` of them) say to the sums.
HWY_INLINE void add_points(const SampsonPoints& points, const LinearisedModel& model, std::size_t i, std::size_t count,
                           V* sums) {
  const D d;
  const V x = hn::Load(d, points.x_previous() + i), y = hn::Load(d, points.y_previous() + i);
  const V u = hn::Load(d, points.x_current() + i), v = hn::Load(d, points.y_current() + i);
  const Lines l = lines_of(model.f, x, y, u, v);
  const V e = hn::MulAdd(u, l.a, hn::MulAdd(v, l.b, l.c));
  const V slope =
      hn::Max(hn::MulAdd(l.a, l.a, hn::MulAdd(l.b, l.b, hn::MulAdd(l.p, l.p, hn::Mul(l.q, l.q)))), hn::Set(d, 1e-30f));
  const V one = hn::Set(d, 1.0f);
  const V inverse_root = hn::Div(one, hn::Sqrt(slope));
  const V r = hn::Mul(e, inverse_root);
  const V e_by_slope = hn::Div(e, slope);
  // rho = r^2 / (1 + r^2 / s^2), so that the weight of r^2 is 1 / (1 + r^2 / s^2)^2.
  const V shrink = hn::Div(one, hn::MulAdd(hn::Mul(r, r), hn::Set(d, model.inverse_scale2), one));
  V weight = hn::Mul(shrink, shrink);
  V cost = hn::Mul(hn::Mul(r, r), shrink);
  if (count < hn::Lanes(d)) {
    weight = hn::IfThenElseZero(hn::FirstN(d, count), weight);
    cost = hn::IfThenElseZero(hn::FirstN(d, count), cost);
  }
  V j[kParameters];
  for (int k = 0; k < kParameters; ++k) {
    const Lines dl = lines_of(model.df[k], x, y, u, v);
    const V de = hn::MulAdd(u, dl.a, hn::MulAdd(v, dl.b, dl.c));
    const V half_dslope = hn::MulAdd(l.a, dl.a, hn::MulAdd(l.b, dl.b, hn::MulAdd(l.p, dl.p, hn::Mul(l.q, dl.q))));
    j[k] = hn::Mul(inverse_root, hn::NegMulAdd(e_by_slope, half_dslope, de));
  }
  int s = 0;
  for (int k = 0; k < kParameters; ++k) {
    const V weighted = hn::Mul(weight, j[k]);
    for (int m = k; m < kParameters; ++m, ++s) sums[s] = hn::MulAdd(weighted, j[m], sums[s]);
  }
  for (int k = 0; k < kParameters; ++k, ++s) sums[s] = hn::MulAdd(hn::Mul(weight, j[k]), r, sums[s]);
  sums[s] = hn::Add(sums[s], cost);
}

void Accumulate(const SampsonPoints& points, const LinearisedModel& model, double* totals) {
  constexpr std::size_t kBlock = 256;  // summed in float, then in double
  const D d;
  for (std::size_t begin = 0; begin < points.size(); begin += kBlock) {
    const std::size_t end = HWY_MIN(points.size(), begin + kBlock);
    V sums[kSums];
    for (V& sum : sums) sum = hn::Zero(d);
    for (std::size_t i = begin; i < end; i += hn::Lanes(d))
      add_points(points, model, i, HWY_MIN(hn::Lanes(d), end - i), sums);
    for (int s = 0; s < kSums; ++s) totals[s] += static_cast<double>(hn::GetLane(hn::SumOfLanes(d, sums[s])));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace pavo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pavo {

HWY_EXPORT(Accumulate);

namespace {

using Step = Eigen::Matrix<double, kParameters, 1>;

struct NormalEquations {
  Eigen::Matrix<double, kParameters, kParameters> A;
  Step b;
  double cost = 0;
};

// Two unit vectors across the unit vector t.
std::array<Eigen::Vector3d, 2> tangents_of(const Eigen::Vector3d& t) {
  const Eigen::Vector3d first = t.unitOrthogonal();
  return {first, t.cross(first)};
}

// R <- exp([w]x) R, t <- the direction of t + a first + b second.
SE3 moved(const SE3& T, const Step& step) {
  const Eigen::Vector3d w = step.head<3>();
  const double angle = w.norm();
  SE3 result = T;
  if (angle > 0) result.R = Eigen::AngleAxisd(angle, w / angle).toRotationMatrix() * T.R;
  const auto [first, second] = tangents_of(T.t);
  result.t = (T.t + step[3] * first + step[4] * second).normalized();
  return result;
}

void store(const Eigen::Matrix3d& m, float* out) {
  for (int i = 0; i < 9; ++i) out[i] = static_cast<float>(m(i / 3, i % 3));
}

class Problem {
 public:
  Problem(const SampsonPoints& points, const Camera& camera, const RefineOptions& options)
      : points_(points), inverse_scale2_(static_cast<float>(1 / (options.scale_px * options.scale_px))) {
    const double f = std::sqrt(camera.fx * camera.fy);  // keeps the elements near 1
    const Eigen::Vector2d principal(camera.cx, camera.cy);
    previous_ = rays_of(camera, f, points.center_previous() - principal);
    current_ = rays_of(camera, f, points.center_current() - principal);
  }

  NormalEquations linearise(const SE3& T) const {
    const auto [first, second] = tangents_of(T.t);
    LinearisedModel model;
    model.inverse_scale2 = inverse_scale2_;
    store(pixels(essential_of(T)), model.f);
    for (int k = 0; k < 3; ++k)
      store(pixels(essential_of({cross_matrix(Eigen::Vector3d::Unit(k)) * T.R, T.t})), model.df[k]);
    store(pixels(essential_of({T.R, first})), model.df[3]);
    store(pixels(essential_of({T.R, second})), model.df[4]);
    std::array<double, kSums> sums{};
    HWY_DYNAMIC_DISPATCH(Accumulate)(points_, model, sums.data());
    NormalEquations equations;
    const double* in = sums.data();
    for (int i = 0; i < kParameters; ++i)
      for (int j = i; j < kParameters; ++j) equations.A(i, j) = equations.A(j, i) = *in++;
    for (int i = 0; i < kParameters; ++i) equations.b[i] = *in++;
    equations.cost = *in;
    return equations;
  }

 private:
  // Centred pixels to rays, times f.
  static Eigen::Matrix3d rays_of(const Camera& camera, double f, const Eigen::Vector2d& center) {
    Eigen::Matrix3d m;
    m << f / camera.fx, 0, f / camera.fx * center.x(), 0, f / camera.fy, f / camera.fy * center.y(), 0, 0, f;
    return m / f;
  }
  Eigen::Matrix3d pixels(const Eigen::Matrix3d& E) const { return current_.transpose() * E * previous_; }

  const SampsonPoints& points_;
  float inverse_scale2_;
  Eigen::Matrix3d previous_, current_;
};

}  // namespace

double refine_motion(const SampsonPoints& points, const Camera& camera, const RefineOptions& options, SE3& T_c_p) {
  if (points.size() < kParameters) return 0;
  const Problem problem(points, camera, options);
  NormalEquations at = problem.linearise(T_c_p);
  double damping = 1e-4;
  for (int i = 0; i < options.max_iterations; ++i) {
    Eigen::Matrix<double, kParameters, kParameters> A = at.A;
    A.diagonal() *= 1 + damping;
    const Step step = -A.ldlt().solve(at.b);
    if (!step.allFinite()) break;
    const SE3 candidate = moved(T_c_p, step);
    const NormalEquations there = problem.linearise(candidate);
    if (there.cost <= at.cost) {
      const bool settled = at.cost - there.cost <= 1e-6 * at.cost || step.norm() < 1e-8;
      T_c_p = candidate;
      at = there;
      damping *= 0.1;
      if (settled) break;
    } else {
      damping *= 30;
      if (damping > 1e6) break;
    }
  }
  T_c_p.R = Eigen::Quaterniond(T_c_p.R).normalized().toRotationMatrix();
  return at.cost / static_cast<double>(points.size());
}

}  // namespace pavo
#endif  // HWY_ONCE
