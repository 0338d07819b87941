// KAZE (Alcantarilla, Bartoli and Davison, ECCV 2012).
#include "bench/detectors/opencv_features.h"

namespace pavo::bench {

void add_kaze(Competitors& to) {
  to.push_back(std::make_unique<WholeFeatures>("KAZE", cv::KAZE::create()));
}

}  // namespace pavo::bench
