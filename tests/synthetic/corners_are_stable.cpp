#include <Eigen/LU>
#include <algorithm>
#include <opencv2/features2d.hpp>
#include <opencv2/video/tracking.hpp>

#include "tests/synthetic/support.h"

namespace pavo {
namespace {

struct Pair {
  cv::Mat first, second;
  Eigen::Matrix3d F;  ///< of the ground truth: x_second' F x_first = 0
};

Pair consecutive(int frame) {
  SyntheticOptions options = test::small_street(frame + 2);
  options.width = 640;
  options.height = 194;
  options.people = false;
  options.noise_sigma = 1;
  SyntheticStreet street(options);
  for (int k = 0; k < frame; ++k) street.skip();
  EncodedImage image;
  FrameStamp stamp;
  Pair pair;
  for (cv::Mat* m : {&pair.first, &pair.second}) {
    street.read(image, stamp);
    *m = cv::Mat(image.height, image.width, CV_8U, image.bytes.data()).clone();
  }
  const auto& T = street.info().groundtruth->T_w_c;
  const SE3 motion = T[static_cast<std::size_t>(frame + 1)].inverse() * T[static_cast<std::size_t>(frame)];
  const Camera& c = *street.info().camera;
  Eigen::Matrix3d K, cross;
  K << c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1;
  cross << 0, -motion.t.z(), motion.t.y(), motion.t.z(), 0, -motion.t.x(), -motion.t.y(), motion.t.x(), 0;
  pair.F = K.inverse().transpose() * cross * motion.R * K.inverse();
  return pair;
}

/// Distances of tracked corners from where the ground truth lets them be (their epipolar lines), pixels, rising.
std::vector<double> residuals(const Pair& pair, const std::vector<cv::KeyPoint>& corners) {
  std::vector<cv::Point2f> from, to, back;
  cv::KeyPoint::convert(corners, from);
  std::vector<unsigned char> found, returned;
  std::vector<float> error;
  const cv::TermCriteria fine(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 40, 0.001);
  cv::calcOpticalFlowPyrLK(pair.first, pair.second, from, to, found, error, {15, 15}, 3, fine);
  cv::calcOpticalFlowPyrLK(pair.second, pair.first, to, back, returned, error, {15, 15}, 3, fine);
  std::vector<double> distances;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (!found[i] || !returned[i] || std::hypot(back[i].x - from[i].x, back[i].y - from[i].y) > 0.5F) continue;
    const Eigen::Vector3d line = pair.F * Eigen::Vector3d(from[i].x, from[i].y, 1);
    distances.push_back(std::abs(line.dot(Eigen::Vector3d(to[i].x, to[i].y, 1))) / line.head<2>().norm());
  }
  std::sort(distances.begin(), distances.end());
  return distances;
}

TEST(SyntheticCorners, AreManySpreadAndMoveAsTheGroundTruthDoes) {
  for (const int frame : {10, 60}) {
    const Pair pair = consecutive(frame);
    std::vector<cv::KeyPoint> corners;
    cv::FAST(pair.first, corners, 20, true);
    EXPECT_GT(corners.size(), 600U) << "frame " << frame;
    int cells[8] = {};
    for (const auto& corner : corners) ++cells[static_cast<int>(corner.pt.x) * 4 / 640 + (corner.pt.y > 97 ? 4 : 0)];
    for (const int cell : cells) EXPECT_GT(cell, 10) << "frame " << frame;

    const auto distances = residuals(pair, corners);
    EXPECT_GT(distances.size(), corners.size() / 2);
    EXPECT_LT(distances[distances.size() / 2], 0.15) << "pixels, frame " << frame;
    EXPECT_LT(distances[distances.size() * 9 / 10], 0.6) << "pixels, frame " << frame;
  }
}

}  // namespace
}  // namespace pavo
