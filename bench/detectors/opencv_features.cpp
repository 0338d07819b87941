#include "bench/detectors/opencv_features.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "bench/detectors/corner_detectors.h"

namespace pavo::bench {

OpenCvFeatures::OpenCvFeatures(std::string name, cv::Ptr<cv::Feature2D> features)
    : name_(std::move(name)), features_(std::move(features)), matcher_(features_->defaultNorm()) {}

void OpenCvFeatures::match(const View& previous, const View& current, PointPairs& pairs) {
  pairs.clear();
  forward_.clear(), backward_.clear();  // BFMatcher appends to what is there
  if (previous.found.keypoints.empty() || current.found.keypoints.empty()) return;
  matcher_.knnMatch(previous.found.descriptors, current.found.descriptors, forward_, 2);
  matcher_.knnMatch(current.found.descriptors, previous.found.descriptors, backward_, 1);
  for (const std::vector<cv::DMatch>& nearest : forward_) {
    if (nearest.empty()) continue;
    const cv::DMatch& best = nearest[0];
    if (nearest.size() > 1 && !(best.distance < kRatio * nearest[1].distance)) continue;
    const std::vector<cv::DMatch>& back = backward_[static_cast<std::size_t>(best.trainIdx)];
    if (back.empty() || back[0].trainIdx != best.queryIdx) continue;
    const cv::Point2f from = previous.found.keypoints[static_cast<std::size_t>(best.queryIdx)].pt,
                      to = current.found.keypoints[static_cast<std::size_t>(best.trainIdx)].pt;
    pairs.push_back({from.x, from.y, to.x, to.y});
  }
}

void WholeFeatures::detect(const Image& image, Found& found) {
  features().detect(mat_of(image), found.keypoints);
}

// Those that cannot be told how many to find are cut to the strongest ones afterwards.
void WholeFeatures::extract(const Image& image, Found& found) {
  features().detectAndCompute(mat_of(image), cv::noArray(), found.keypoints, found.descriptors);
  if (found.keypoints.size() <= kMaxKeypoints) return;
  std::swap(found.keypoints, all_.keypoints);
  cv::swap(found.descriptors, all_.descriptors);
  order_.resize(all_.keypoints.size());
  std::iota(order_.begin(), order_.end(), 0);
  std::stable_sort(order_.begin(), order_.end(), [&](int a, int b) {
    return all_.keypoints[static_cast<std::size_t>(a)].response > all_.keypoints[static_cast<std::size_t>(b)].response;
  });
  found.keypoints.clear();
  found.descriptors.create(kMaxKeypoints, all_.descriptors.cols, all_.descriptors.type());
  for (int i = 0; i < kMaxKeypoints; ++i) {
    const int from = order_[static_cast<std::size_t>(i)];
    found.keypoints.push_back(all_.keypoints[static_cast<std::size_t>(from)]);
    all_.descriptors.row(from).copyTo(found.descriptors.row(i));
  }
}

void DescribedFast::detect(const Image& image, Found& found) {
  if (!corners_ || width_ != image.width() || height_ != image.height()) {
    const FeatureOptions options{.max_features = kMaxKeypoints, .descriptors = false};
    corners_ = std::make_unique<ExtractFeatures>(options, image.width(), image.height());
    width_ = image.width(), height_ = image.height();
  }
  (*corners_)(image, found.features, scratch_);
  found.keypoints.clear();
  constexpr float kUpright = 0;
  for (const Keypoint& keypoint : found.features.keypoints)
    found.keypoints.emplace_back(keypoint.x, keypoint.y, size_, kUpright, keypoint.response, 0);
}

void DescribedFast::extract(const Image& image, Found& found) {
  detect(image, found);
  features().compute(mat_of(image), found.keypoints, found.descriptors);
}

}  // namespace pavo::bench
