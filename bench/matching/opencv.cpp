#include <algorithm>
#include <opencv2/features2d.hpp>

#include "bench/matching/competitors.h"

namespace pavo::bench {
namespace {

cv::Mat as_mat(const Features& f) {
  return cv::Mat(static_cast<int>(f.size()), Features::kDescriptorSize, CV_32F,
                 const_cast<float*>(f.descriptors.get()));
}

}  // namespace

void match_opencv(Problem& problem, Pairs& pairs) {
  std::vector<cv::DMatch> found;
  cv::BFMatcher(cv::NORM_L2, true).match(as_mat(problem.previous), as_mat(problem.current), found);
  pairs.clear();
  for (const cv::DMatch& m : found) pairs.emplace_back(m.queryIdx, m.trainIdx);
  std::sort(pairs.begin(), pairs.end());
}

}  // namespace pavo::bench
