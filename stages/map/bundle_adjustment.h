// Local bundle adjustment: poses of keyframes and points on rays that explain the pixels best.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "stages/map/ray_point.h"
#include "stages/map/se3_step.h"
#include "types/camera.h"

namespace pavo {

struct BundleOptions {
  int iterations = 6;        ///< of Levenberg and Marquardt, at most
  double loss_scale = 1.2;   ///< of Cauchy's loss, in standard deviations of a pixel
  double least_gain = 1e-4;  ///< relative; a step that lowers the cost by less ends the adjustment
  double initial_damping = 1e-5;
};

struct BundleObservation {
  int pose = 0;
  int point = 0;
  double x = 0, y = 0;       ///< pixel
  double inverse_sigma = 1;  ///< 1 / px
};

struct BundlePose {
  SE3 T_w_c;
  bool fixed = false;
};

struct BundlePoint {
  RayPoint ray;
  int first = 0, count = 0;  ///< its observations: [first, first + count)
  /// A Gaussian prior of rho; 0: none.
  double prior_rho = 0, prior_information = 0;
};

/// The problem: observations are sorted by point. Solved in place.
struct Bundle {
  static constexpr int kMaxFree = 16;  ///< poses that are not fixed
  std::vector<BundlePose> poses;
  std::vector<BundlePoint> points;
  std::vector<BundleObservation> observations;
  /// The error of the camera's calibration, and a Gaussian prior of it. Information 0: it is not adjusted.
  LensError lens = LensError::Zero(), prior_lens = LensError::Zero();
  Eigen::Matrix2d lens_information = Eigen::Matrix2d::Zero();
  void clear() {
    poses.clear();
    points.clear();
    observations.clear();
  }
};

struct BundleSummary {
  double initial_cost = 0, final_cost = 0;
  int iterations = 0;  ///< steps that were tried
  /// Of Bundle::lens, the prior's included, whatever poses and points are; 0 where it was not adjusted.
  Eigen::Matrix2d lens_information = Eigen::Matrix2d::Zero();
};

/// Minimises the robust sum of squared, whitened reprojection errors over the poses that are not fixed and all points
/// (Levenberg and Marquardt; the points are eliminated by the Schur complement: Triggs et al., Bundle Adjustment: A
/// Modern Synthesis, 2000). The points' sigma_rho is set from the curvature at the end, the poses held. Pure but for
/// the scratch; allocates only to grow it. Throws std::invalid_argument for more than kMaxFree free poses.
class BundleAdjustment {
 public:
  BundleAdjustment(const Camera& camera, const BundleOptions& options) : camera_(camera), options_(options) {}

  BundleSummary operator()(Bundle& bundle);

  /// The robust cost of the bundle as it stands.
  double cost(const Bundle& bundle) const;

 private:
  static constexpr int kMaxSize = 6 * Bundle::kMaxFree + 2;
  using Reduced = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxSize, kMaxSize>;
  using ReducedVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxSize, 1>;
  using Block63 = Eigen::Matrix<double, 6, 3>;
  using Block23 = Eigen::Matrix<double, 2, 3>;

  void linearise(const Bundle& bundle);
  void reduce(const Bundle& bundle, double damping);
  void step(const Bundle& bundle, const ReducedVector& poses, Bundle& out) const;
  Eigen::Matrix2d marginal_of_lens() const;

  Camera camera_;
  BundleOptions options_;
  std::vector<int> column_;  ///< of each pose in the reduced system, -1: fixed
  int size_ = 0;
  int lens_ = -1;                             ///< column of the lens, the last; -1: it is not adjusted
  std::vector<Block63> cross_;                ///< per observation: J_pose^T W J_point
  std::vector<Block23> lens_cross_;           ///< per point: the sum of J_lens^T W J_point
  std::vector<Eigen::Matrix3d> H_, inverse_;  ///< per point
  std::vector<Eigen::Vector3d> b_;
  Reduced poses_H_, reduced_;
  ReducedVector poses_b_, reduced_b_;
  std::vector<BundlePose> saved_poses_;
  std::vector<BundlePoint> saved_points_;
  LensError saved_lens_;
};

}  // namespace pavo
