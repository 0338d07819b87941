#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "bench/undistort/competitors.h"

namespace pavo::bench {

void prepare_opencv(Problem& problem) {
  const Camera& c = problem.camera;
  const cv::Matx33d k(c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
  const cv::Size size(c.width, c.height);
  const auto& d = c.distortion;
  if (c.lens == Lens::equidistant)
    cv::fisheye::initUndistortRectifyMap(k, cv::Vec4d(d[0], d[1], d[2], d[3]), cv::Matx33d::eye(), k, size, CV_16SC2,
                                         problem.opencv_positions, problem.opencv_weights);
  else
    cv::initUndistortRectifyMap(k, cv::Mat(1, 8, CV_64F, const_cast<double*>(d.data())), cv::noArray(), k, size,
                                CV_16SC2, problem.opencv_positions, problem.opencv_weights);
}

void remap_opencv(Problem& problem) {
  const cv::Mat raw(problem.raw.height(), problem.raw.width(), CV_8UC1, problem.raw.row(0),
                    static_cast<std::size_t>(problem.raw.stride()));
  cv::remap(raw, problem.opencv_image, problem.opencv_positions, problem.opencv_weights, cv::INTER_LINEAR);
}

}  // namespace pavo::bench
