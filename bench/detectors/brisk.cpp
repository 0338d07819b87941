// BRISK (Leutenegger, Chli and Siegwart, ICCV 2011). Its descriptor finds an orientation of its own.
#include "bench/detectors/opencv_features.h"

namespace pavo::bench {

void add_brisk(Competitors& to) {
  constexpr float kSize = 12;  // of BRISK's own keypoints at the image's resolution
  to.push_back(std::make_unique<WholeFeatures>("BRISK", cv::BRISK::create()));
  to.push_back(std::make_unique<DescribedFast>("FAST (grid) + BRISK", cv::BRISK::create(), kSize));
}

}  // namespace pavo::bench
