// OpenCV's RANSAC draws seven points (a cubic, up to three models); its FM_8POINT is without RANSAC.
#include <opencv2/calib3d.hpp>

#include "bench/ransac/competitors.h"

namespace pavo::bench {

void ransac_opencv(Problem& problem, Solution& solution) {
  std::vector<cv::Point2f> previous, current;
  for (const PointPair& pair : problem.pairs) {
    previous.emplace_back(pair.x_previous, pair.y_previous);
    current.emplace_back(pair.x_current, pair.y_current);
  }
  cv::setRNGSeed(static_cast<int>(problem.seed));
  const cv::Mat F =
      cv::findFundamentalMat(previous, current, cv::FM_RANSAC, kThresholdPx, kConfidence, 3000, solution.is_inlier);
  solution.F.setZero();
  if (F.rows != 3) return;
  for (int i = 0; i < 9; ++i) solution.F(i / 3, i % 3) = F.at<double>(i / 3, i % 3);
  solution.iterations = 0;
}

}  // namespace pavo::bench
