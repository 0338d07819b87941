// A calibrated camera: how a ray in front of it becomes a pixel.
#pragma once

#include <array>

namespace pavo {

/// The lens, as a map from the ideal image plane (X/Z, Y/Z) to the distorted one.
enum class Lens {
  rectified,          ///< no distortion
  radial_tangential,  ///< k1 k2 p1 p2 [k3 [k4 k5 k6]], OpenCV's and ROS's plumb_bob and rational_polynomial order
  equidistant,        ///< fisheye k1 k2 k3 k4 (Kannala and Brandt, PAMI 2006; OpenCV's cv::fisheye)
};

/// Intrinsics in pixels for an image of width x height; pixel centres are at integer coordinates.
/// u = fx x' + cx, v = fy y' + cy, where (x', y') is the distorted point of the image plane.
struct Camera {
  int width = 0;
  int height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;
  Lens lens = Lens::rectified;
  std::array<double, 8> distortion{};  ///< in the order that `lens` names; unused ones are 0
};

}  // namespace pavo
