// What all competitors with a descriptor of OpenCV's share.
#pragma once

#include <opencv2/features2d.hpp>
#include <utility>

#include "bench/detectors/competitor.h"
#include "stages/features/extract.h"

namespace pavo::bench {

/// Mutual nearest neighbours with the ratio test, in the descriptors' own norm, by cv::BFMatcher.
class OpenCvFeatures : public Competitor {
 public:
  OpenCvFeatures(std::string name, cv::Ptr<cv::Feature2D> features);
  std::string name() const override { return name_; }
  void match(const View& previous, const View& current, PointPairs& pairs) override;

 protected:
  cv::Feature2D& features() { return *features_; }

 private:
  std::string name_;
  cv::Ptr<cv::Feature2D> features_;
  cv::BFMatcher matcher_;
  std::vector<std::vector<cv::DMatch>> forward_, backward_;
};

/// Detector and descriptor by one class, which shares its scale space between them.
class WholeFeatures final : public OpenCvFeatures {
 public:
  using OpenCvFeatures::OpenCvFeatures;
  void detect(const Image& image, Found& found) override;
  void extract(const Image& image, Found& found) override;

 private:
  Found all_;
  std::vector<int> order_;
};

/// OpenCV's descriptor on the very corners that pavo describes with SURF, upright too: what does the descriptor alone
/// change? `size`: the keypoints' diameter in pixels, which the descriptor's window follows.
class DescribedFast final : public OpenCvFeatures {
 public:
  DescribedFast(std::string name, cv::Ptr<cv::Feature2D> features, float size)
      : OpenCvFeatures(std::move(name), std::move(features)), size_(size) {}
  void detect(const Image& image, Found& found) override;
  void extract(const Image& image, Found& found) override;

 private:
  float size_;
  std::unique_ptr<ExtractFeatures> corners_;
  ExtractFeatures::Scratch scratch_;
  int width_ = 0, height_ = 0;
};

}  // namespace pavo::bench
