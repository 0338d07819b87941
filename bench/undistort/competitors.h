#pragma once

#include <opencv2/core/mat.hpp>

#include "stages/undistort/undistort.h"

namespace pavo::bench {

/// One picture through one lens, both ways.
struct Problem {
  Camera camera;
  Undistort undistort;
  Image raw, image;
  cv::Mat opencv_positions, opencv_weights, opencv_image;  // fixed-point maps: CV_16SC2 and CV_16UC1

  explicit Problem(const Camera& camera);
};

void remap_pavo(Problem& problem);
void remap_opencv(Problem& problem);
void prepare_opencv(Problem& problem);

}  // namespace pavo::bench
