// OpenCV's corners and regions with pavo's upright SURF: what does the detector alone change?
#include <cmath>
#include <utility>

#include "bench/detectors/corner_detectors.h"
#include "bench/detectors/surf_features.h"
#include "stages/features/surf.h"

namespace pavo::bench {
namespace {

class CornersSurf final : public SurfFeatures {
 public:
  CornersSurf(std::string detector_name, cv::Ptr<cv::Feature2D> detector)
      : name_(std::move(detector_name) + " + SURF"), detector_(std::move(detector)) {}
  std::string name() const override { return name_; }

  void detect(const Image& image, Found& found) override {
    detector_->detect(mat_of(image), found.keypoints);
    keep_strongest(found.keypoints);
  }
  void extract(const Image& image, Found& found) override {
    detect(image, found);
    found.features.keypoints.clear();
    const float low = static_cast<float>(surf_.support());
    for (const cv::KeyPoint& keypoint : found.keypoints) {
      const float x = std::round(keypoint.pt.x), y = std::round(keypoint.pt.y);
      if (x < low || y < low || x + low >= static_cast<float>(image.width()) ||
          y + low >= static_cast<float>(image.height()))
        continue;
      found.features.keypoints.push_back({.x = x, .y = y, .response = keypoint.response});
    }
    surf_(image.view(), found.features, scratch_);
  }

 private:
  std::string name_;
  cv::Ptr<cv::Feature2D> detector_;
  Surf surf_;
  Surf::Scratch scratch_;
};

}  // namespace

void add_corners_surf(Competitors& to) {
  to.push_back(std::make_unique<CornersSurf>("cv FAST (no grid)", fast_detector()));
  to.push_back(std::make_unique<CornersSurf>("cv AGAST", agast_detector()));
  to.push_back(std::make_unique<CornersSurf>("cv Shi-Tomasi", shi_tomasi_detector()));
  to.push_back(std::make_unique<CornersSurf>("cv Harris", harris_detector()));
  to.push_back(std::make_unique<CornersSurf>("cv MSER", region_detector()));
}

}  // namespace pavo::bench
