// The inside of the odometry as a picture: keypoints, matches, people, the path so far.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "pavo/frame.h"

namespace pavo {

/// What is drawn of a frame, copied out of its slot.
struct FrameSnapshot {
  std::int64_t index = 0;
  std::string name;
  bool failed = false;
  Image image;  ///< empty where the frame failed before it had one
  std::vector<Keypoint> keypoints;
  Detections detections;
  People people;
  PoseResult pose;
};

/// Replaces `snapshot` (which keeps its memory) by the frame.
void take_snapshot(const Frame& frame, std::int64_t index, bool failed, FrameSnapshot& snapshot);

/// BGR. Keypoints gray, matches from where the point was to where it is (inliers green, outliers red), detections thin
/// and carried boxes thick in yellow, keypoints dropped on people orange, one line of figures, and a map of `path`
/// (positions of all frames so far, in the world) in the upper right corner.
cv::Mat draw_frame(const FrameSnapshot& snapshot, const std::vector<Eigen::Vector3d>& path);

}  // namespace pavo
