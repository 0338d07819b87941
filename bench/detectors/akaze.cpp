// AKAZE (Alcantarilla, Nuevo and Bartoli, BMVC 2013).
#include "bench/detectors/opencv_features.h"

namespace pavo::bench {

void add_akaze(Competitors& to) {
  to.push_back(std::make_unique<WholeFeatures>("AKAZE", cv::AKAZE::create()));
}

}  // namespace pavo::bench
