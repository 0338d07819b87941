// Detectors that Debian's OpenCV ships and that have no descriptor of their own: of corners and regions. Not
// cv::SimpleBlobDetector, which finds nothing to match in some frames of KITTI.
#pragma once

#include <opencv2/features2d.hpp>

#include "bench/detectors/competitor.h"

namespace pavo::bench {

/// FAST and AGAST at threshold 20, as "F" is. Of the others as many as allowed, 3 pixels apart (as FAST's non-maximum
/// suppression leaves them at least 2); Harris at a lower quality level than the default 0.01, with which it found 489
/// and 1080 corners in two frames of KITTI.
inline cv::Ptr<cv::Feature2D> fast_detector() {
  return cv::FastFeatureDetector::create(20, true);
}
inline cv::Ptr<cv::Feature2D> agast_detector() {
  return cv::AgastFeatureDetector::create(20, true);
}
inline cv::Ptr<cv::Feature2D> shi_tomasi_detector() {
  return cv::GFTTDetector::create(kMaxKeypoints, 0.01, 3);
}
inline cv::Ptr<cv::Feature2D> harris_detector() {
  return cv::GFTTDetector::create(kMaxKeypoints, 0.0001, 3, 3, true);
}
inline cv::Ptr<cv::Feature2D> region_detector() {
  return cv::MSER::create();
}

/// The strongest ones of the whole image, as OpenCV's own detectors choose them.
inline void keep_strongest(std::vector<cv::KeyPoint>& keypoints) {
  cv::KeyPointsFilter::retainBest(keypoints, kMaxKeypoints);
  if (keypoints.size() > kMaxKeypoints) keypoints.resize(kMaxKeypoints);  // ties
}

}  // namespace pavo::bench
