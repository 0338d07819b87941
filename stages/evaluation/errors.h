// How far an estimated path is from the true one: the measures of the field, each as a function of paired poses.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "stages/evaluation/alignment.h"
#include "stages/evaluation/association.h"
#include "types/pose.h"

namespace pavo {

struct Statistics {
  double rmse = 0, mean = 0, median = 0, max = 0;
};

/// Of one value or more (std::invalid_argument). The median of an even number is the mean of the middle two.
Statistics statistics(std::vector<double> values);

/// The angle of a rotation, in [0, pi]. By atan2 of its sine and cosine: the usual acos((tr R - 1) / 2) turns the 1e-7
/// that a file rounds away into 3e-4 rad.
double rotation_angle_rad(const Eigen::Matrix3d& R);

/// ATE: |S e_i - g_i| over all camera centres, metres (Sturm et al., IROS 2012).
Statistics absolute_errors_m(const PosePairs& pairs, const Similarity& S);

/// The root mean square error of each of the 12 parameters of [R | t], as a 3x4 table: the left 3x3 part without unit,
/// the last column in metres.
using ParameterRmse = Eigen::Matrix<double, 3, 4>;

/// Of the poses, each path in the frame of its own first camera: E_0^-1 E_i against G_0^-1 G_i. The estimate's
/// translations are multiplied by `scale` first, here and below.
ParameterRmse pose_rmse(const PosePairs& pairs, double scale);
/// Of the frame-to-frame motions: E_i^-1 E_i+1 against G_i^-1 G_i+1.
ParameterRmse motion_rmse(const PosePairs& pairs, double scale);

/// RPE: the error of every frame-to-frame motion, (G_i^-1 G_i+1)^-1 (E_i^-1 E_i+1) (Sturm et al., IROS 2012).
struct MotionErrors {
  Statistics translation_m;
  Statistics rotation_deg;
};
MotionErrors motion_errors(const PosePairs& pairs, double scale);

/// KITTI's odometry errors over stretches of the true path (Geiger et al., CVPR 2012).
struct SegmentErrors {
  double t_rel_percent = 0;       ///< mean over the segments of |translation error| / length
  double r_rel_deg_per_100m = 0;  ///< mean over the segments of the rotation error / length
  std::size_t segments = 0;       ///< one or more
};
struct SegmentErrorsByLength {
  std::optional<SegmentErrors> all;  ///< the mean over all segments of all lengths; nothing: no segment fits
  struct Row {
    double length_m = 0;
    std::optional<SegmentErrors> errors;
  };
  std::vector<Row> lengths;  ///< one per length that was asked for
};

/// A segment begins at frame 0, step, 2 step, ... and ends at the first frame that is more than the length away along
/// the true path, as in KITTI's own program; errors are divided by the nominal length. step >= 1, lengths > 0.
SegmentErrorsByLength segment_errors(const PosePairs& pairs, double scale, std::span<const double> lengths_m, int step);

/// KITTI's 100, 200, ... 800 m; 10, 20, ... 50 m where the true path is shorter than 100 m.
std::vector<double> segment_lengths_m(double path_length_m);

}  // namespace pavo
