#include "stages/pose/standstill.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cstddef>

#include "stages/pose/picture_cells.h"

namespace pavo {
namespace {

// The image motion of a pair: what it is, and how it depends on a small rotation w: (row_x w, row_y w).
struct Flow {
  Eigen::Vector2d motion;
  Eigen::Matrix<double, 2, 3> by_rotation;
};

Flow flow_of(const PointPair& pair, const Camera& camera) {
  const double x = (pair.x_previous - camera.cx) / camera.fx, y = (pair.y_previous - camera.cy) / camera.fy;
  Flow flow;
  flow.motion = {static_cast<double>(pair.x_current) - pair.x_previous,
                 static_cast<double>(pair.y_current) - pair.y_previous};
  flow.by_rotation << -camera.fx * x * y, camera.fx * (1 + x * x), -camera.fx * y,  //
      -camera.fy * (1 + y * y), camera.fy * x * y, camera.fy * x;
  return flow;
}

// How much of the picture each pair stands for: its share of the pairs in its cell.
class Coverage {
 public:
  Coverage(std::span<const PointPair> pairs, const Camera& camera) : cells_{camera.width, camera.height} {
    for (const PointPair& pair : pairs) occupied_ += ++pairs_in_[cell_of(pair)] == 1;
  }
  double of(const PointPair& pair) const { return 1.0 / (pairs_in_[cell_of(pair)] * occupied_); }

 private:
  std::size_t cell_of(const PointPair& pair) const { return cells_.index_of(pair.x_current, pair.y_current); }

  PictureCells cells_;
  std::array<int, PictureCells::kCount> pairs_in_{};
  double occupied_ = 0;
};

// Marks the pairs whose motion differs from the rotation's by less than limit_px; the share of the picture they are.
double mark_near(std::span<const PointPair> pairs, const Coverage& coverage, const Camera& camera,
                 const Eigen::Vector3d& rotation, double limit_px, std::span<std::uint8_t> near) {
  double share = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Flow flow = flow_of(pairs[i], camera);
    near[i] = (flow.motion - flow.by_rotation * rotation).squaredNorm() < limit_px * limit_px;
    if (near[i]) share += coverage.of(pairs[i]);
  }
  return share;
}

}  // namespace

Eigen::Vector3d small_rotation(std::span<const PointPair> pairs, const Camera& camera) {
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();
  for (const double scale_px : {1.5, 1.5, 0.8, 0.8, 0.4, 0.4, 0.25, 0.25}) {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (const PointPair& pair : pairs) {
      const Flow flow = flow_of(pair, camera);
      const double square = (flow.motion - flow.by_rotation * rotation).squaredNorm();
      const double root_weight = 1 / (1 + square / (scale_px * scale_px));
      const double weight = root_weight * root_weight;
      A += weight * flow.by_rotation.transpose() * flow.by_rotation;
      b += weight * flow.by_rotation.transpose() * flow.motion;
    }
    const Eigen::Vector3d solution = A.ldlt().solve(b);
    if (!solution.allFinite()) break;  // all points in one place
    rotation = solution;
  }
  return rotation;
}

bool stands_still(std::span<const PointPair> pairs, const Camera& camera, const StandstillOptions& options,
                  std::vector<std::uint8_t>& at_rest) {
  at_rest.assign(pairs.size(), 0);
  if (pairs.size() < static_cast<std::size_t>(std::max(options.min_matches, 1))) return false;
  const Coverage coverage(pairs, camera);
  const auto near = [&](const Eigen::Vector3d& rotation, double limit_px) {
    return mark_near(pairs, coverage, camera, rotation, limit_px, at_rest) >= options.min_share;
  };
  if (near(Eigen::Vector3d::Zero(), options.max_motion_px) &&
      (near(Eigen::Vector3d::Zero(), options.max_residual_px) ||
       near(small_rotation(pairs, camera), options.max_residual_px)))
    return true;
  std::fill(at_rest.begin(), at_rest.end(), std::uint8_t{0});
  return false;
}

}  // namespace pavo
