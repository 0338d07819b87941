#include "stages/pose/eight_point.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace pavo {
namespace {

using Row = std::array<double, 9>;

// x'^T F x as a row times F's elements, row-major.
Row row_of(const NormalisedPair& p) {
  const auto [x, y, u, v] = p;
  return {u * x, u * y, u, v * x, v * y, v, x, y, 1.0};
}

}  // namespace

Eigen::Matrix3d Normalisation::matrix() const {
  Eigen::Matrix3d N;
  N << scale, 0, -scale * cx, 0, scale, -scale * cy, 0, 0, 1;
  return N;
}

PairNormalisation normalisation_of(std::span<const PointPair> pairs) {
  PairNormalisation by;
  if (pairs.empty()) return by;
  const double n = static_cast<double>(pairs.size());
  for (const PointPair& p : pairs) {
    by.previous.cx += p.x_previous, by.previous.cy += p.y_previous;
    by.current.cx += p.x_current, by.current.cy += p.y_current;
  }
  by.previous.cx /= n, by.previous.cy /= n, by.current.cx /= n, by.current.cy /= n;
  double spread_previous = 0, spread_current = 0;
  for (const PointPair& p : pairs) {
    const double x = p.x_previous - by.previous.cx, y = p.y_previous - by.previous.cy;
    const double u = p.x_current - by.current.cx, v = p.y_current - by.current.cy;
    spread_previous += x * x + y * y;
    spread_current += u * u + v * v;
  }
  if (spread_previous > 0) by.previous.scale = std::sqrt(2 * n / spread_previous);
  if (spread_current > 0) by.current.scale = std::sqrt(2 * n / spread_current);
  return by;
}

NormalisedPair normalised(const PointPair& pair, const PairNormalisation& by) {
  return {by.previous.scale * (pair.x_previous - by.previous.cx),
          by.previous.scale * (pair.y_previous - by.previous.cy), by.current.scale * (pair.x_current - by.current.cx),
          by.current.scale * (pair.y_current - by.current.cy)};
}

// Gauss-Jordan with pivots from the whole remaining rows: what is left of the nine columns is the free unknown.
bool eight_point_minimal(std::span<const NormalisedPair, 8> sample, Eigen::Matrix3d& F) {
  std::array<Row, 8> A;
  for (std::size_t i = 0; i < 8; ++i) A[i] = row_of(sample[i]);
  std::array<std::size_t, 9> column{0, 1, 2, 3, 4, 5, 6, 7, 8};  // the unknown that stands in each column
  for (std::size_t k = 0; k < 8; ++k) {
    // Column pivoting within row k: no search over rows, yet the pivot is never small in a sound system.
    std::size_t pivot = k;
    for (std::size_t c = k + 1; c < 9; ++c)
      if (std::abs(A[k][c]) > std::abs(A[k][pivot])) pivot = c;
    if (std::abs(A[k][pivot]) < 1e-10) return false;
    if (pivot != k) {
      std::swap(column[k], column[pivot]);
      for (Row& row : A) std::swap(row[k], row[pivot]);
    }
    const double inverse = 1 / A[k][k];
    for (std::size_t r = k + 1; r < 8; ++r) {
      const double factor = A[r][k] * inverse;
      for (std::size_t c = k + 1; c < 9; ++c) A[r][c] -= factor * A[k][c];
    }
  }
  std::array<double, 9> unknown;
  unknown[8] = 1;
  for (std::size_t k = 8; k-- > 0;) {
    double sum = 0;
    for (std::size_t c = k + 1; c < 9; ++c) sum += A[k][c] * unknown[c];
    unknown[k] = -sum / A[k][k];
  }
  for (std::size_t c = 0; c < 9; ++c)
    F(static_cast<Eigen::Index>(column[c] / 3), static_cast<Eigen::Index>(column[c] % 3)) = unknown[c];
  F /= F.norm();
  return true;
}

void EightPointSystem::add(const NormalisedPair& pair, double weight) {
  const Row row = row_of(pair);
  double* out = upper_.data();
  for (std::size_t i = 0; i < 9; ++i) {
    const double factor = weight * row[i];
    for (std::size_t j = i; j < 9; ++j) *out++ += factor * row[j];
  }
}

Eigen::Matrix3d EightPointSystem::solve() const {
  Eigen::Matrix<double, 9, 9> M;
  const double* in = upper_.data();
  for (Eigen::Index i = 0; i < 9; ++i)
    for (Eigen::Index j = i; j < 9; ++j) M(i, j) = M(j, i) = *in++;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> eigen(M);
  const Eigen::Matrix<double, 9, 1> f = eigen.eigenvectors().col(0);
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(f.data());
}

// U diag(s1, s2, 0) V^T = F - F v3 v3^T.
Eigen::Matrix3d nearest_rank2(const Eigen::Matrix3d& F) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d v = svd.matrixV().col(2);
  return F - (F * v) * v.transpose();
}

// (F^T F)^-1 = adj(F) adj(F)^T / det^2. Its largest eigenvector v is F's null direction; F - F v v^T has it exactly.
Eigen::Matrix3d rank2_by_iteration(const Eigen::Matrix3d& F) {
  Eigen::Matrix3d adjugate;
  adjugate.row(0) = F.col(1).cross(F.col(2));
  adjugate.row(1) = F.col(2).cross(F.col(0));
  adjugate.row(2) = F.col(0).cross(F.col(1));
  const Eigen::Matrix3d inverse_square = adjugate * adjugate.transpose();
  Eigen::Index largest;
  inverse_square.diagonal().maxCoeff(&largest);
  Eigen::Vector3d v = inverse_square.col(largest).normalized();
  for (int i = 0; i < 2; ++i) v = (inverse_square * v).normalized();
  if (!v.allFinite()) return F;  // rank 1 already
  return F - (F * v) * v.transpose();
}

Eigen::Matrix3d denormalised(const Eigen::Matrix3d& F, const PairNormalisation& by) {
  const Eigen::Matrix3d pixels = by.current.matrix().transpose() * F * by.previous.matrix();
  return pixels / pixels.norm();
}

Eigen::Matrix3d eight_point(std::span<const PointPair> pairs) {
  if (pairs.size() < 8) throw std::invalid_argument("eight-point: at least 8 pairs are needed");
  const PairNormalisation by = normalisation_of(pairs);
  EightPointSystem system;
  for (const PointPair& pair : pairs) system.add(normalised(pair, by), 1.0);
  return denormalised(nearest_rank2(system.solve()), by);
}

}  // namespace pavo
