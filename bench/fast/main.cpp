// How long do our FAST corners take, measured in cv::FAST(image, 20, true) on one thread ("F")?
#include <hwy/highway.h>
#include <cstdio>
#include <opencv2/features2d.hpp>

#include "bench/fast/picture.h"
#include "stages/features/fast.h"

namespace pavo::bench {
namespace {

bool same_corners(const cv::Mat& picture, const Image& image, int threshold) {
  std::vector<cv::KeyPoint> theirs;
  cv::FAST(picture, theirs, threshold, true);
  FastScratch scratch;
  const std::span<const Corner> ours = detect_fast(image.view(), threshold, scratch);
  const auto same = [](const Corner& a, const cv::KeyPoint& b) {
    return a.x == static_cast<int>(b.pt.x) && a.y == static_cast<int>(b.pt.y) &&
           a.score == static_cast<int>(b.response);
  };
  return std::equal(ours.begin(), ours.end(), theirs.begin(), theirs.end(), same);
}

void compare(const cv::Mat& picture, const Image& image, int threshold) {
  std::vector<cv::KeyPoint> theirs;
  FastScratch scratch;
  std::size_t corners = 0;
  const std::vector<double> ms =
      median_ms(101, {[&] { cv::FAST(picture, theirs, threshold, true); },
                      [&] { corners = detect_fast(image.view(), threshold, scratch).size(); }});
  std::printf("  threshold %3d: %6zu corners, cv::FAST %6.3f ms, ours %6.3f ms, ratio %.3f\n", threshold, corners,
              ms[0], ms[1], ms[1] / ms[0]);
}

int run(int argc, char** argv) {
  cv::setNumThreads(1);
  const cv::Mat theirs = picture(argc, argv);
  const Image ours = to_image(theirs);
  for (int threshold : {0, 5, 7, 10, 20, 40, 100, 254, 255}) {
    if (!same_corners(theirs, ours, threshold)) {
      std::fprintf(stderr, "threshold %d: our corners are not cv::FAST's\n", threshold);
      return 1;
    }
  }
  std::printf("the same corners and scores as cv::FAST at every threshold\n");
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().DeInit();
    std::printf("%s\n", hwy::TargetName(target));
    for (int threshold : {7, 20}) compare(theirs, ours, threshold);
    hwy::SetSupportedTargetsForTest(0);
  }
  return 0;
}

}  // namespace
}  // namespace pavo::bench

int main(int argc, char** argv) {
  return pavo::bench::run(argc, argv);
}
