// ORB (Rublee et al., ICCV 2011): FAST on a pyramid with turned BRIEF; and its pattern, upright, on pavo's corners: the
// nearest to FAST + BRIEF (Calonder et al., ECCV 2010) that Debian's OpenCV can do.
#include "bench/detectors/opencv_features.h"

namespace pavo::bench {

void add_orb(Competitors& to) {
  constexpr float kSize = 7;  // FAST's own; the pattern's 31 pixels do not follow it
  const auto create = [] { return cv::ORB::create(kMaxKeypoints); };
  to.push_back(std::make_unique<WholeFeatures>("ORB", create()));
  to.push_back(std::make_unique<DescribedFast>("FAST (grid) + BRIEF (ORB's pattern)", create(), kSize));
}

}  // namespace pavo::bench
