// OpenCV's default people detector as the stage `scan`: the competitor that ours is measured against.
#pragma once

#include <opencv2/objdetect.hpp>
#include <vector>

#include "stages/people/people.h"
#include "types/image.h"

namespace pavo {

struct ScanOpencvOptions {
  int stride_px = 8;            ///< of the windows, both ways; a multiple of the cell size, 8
  double scale_step = 1.05;     ///< from one pyramid level to the next, > 1
  float threshold = 0;          ///< smallest margin of the support vector machine that counts
  float largest_share = 0.65f;  ///< of the smaller box, before the weaker one of two is dropped
};

/// HOG of 64x128 windows and cv::HOGDescriptor::getDefaultPeopleDetector() (Dalal and Triggs, CVPR 2005; trained on
/// INRIA by others). Scores are margins, not probabilities. No padding: a person must be in the image with 12 % of
/// their height to spare above and below. Allocates inside OpenCV on every call. Throws std::invalid_argument on bad
/// options.
class ScanPeopleOpencv {
 public:
  struct Scratch {
    std::vector<cv::Rect> windows;
    std::vector<double> margins;
  };

  explicit ScanPeopleOpencv(const ScanOpencvOptions& options = {});

  /// The boxes of the persons in `image`, best first; none if the image is smaller than a window.
  void operator()(const Image& image, Detections& detections, Scratch& scratch) const;

 private:
  ScanOpencvOptions options_;
  cv::HOGDescriptor hog_;
};

}  // namespace pavo
