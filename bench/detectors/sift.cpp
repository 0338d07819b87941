// SIFT (Lowe, IJCV 2004).
#include "bench/detectors/opencv_features.h"

namespace pavo::bench {

void add_sift(Competitors& to) {
  constexpr float kSize = 7;  // FAST's own
  to.push_back(std::make_unique<WholeFeatures>("SIFT", cv::SIFT::create(kMaxKeypoints)));
  to.push_back(std::make_unique<DescribedFast>("FAST (grid) + SIFT", cv::SIFT::create(), kSize));
}

}  // namespace pavo::bench
