// Which keypoint of the previous frame is which keypoint of the current one.
#pragma once

#include <vector>

namespace pavo {

struct Match {
  int previous = 0;    ///< index into the previous frame's keypoints
  int current = 0;     ///< index into the current frame's keypoints
  float distance = 0;  ///< L2 distance of the descriptors; 0 for tracks
};
using Matches = std::vector<Match>;

/// The same as coordinates: pixels of the rectified images. What the estimators read, whoever found the match.
struct PointPair {
  float x_previous = 0, y_previous = 0;
  float x_current = 0, y_current = 0;
};
using PointPairs = std::vector<PointPair>;

}  // namespace pavo
