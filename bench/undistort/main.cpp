// How long does it take to take the lens out of a frame, beside cv::remap with fixed-point maps, one thread? First: do
// both show the same picture?
#include <hwy/highway.h>
#include <time.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <vector>

#include "bench/undistort/competitors.h"

namespace pavo::bench {

Problem::Problem(const Camera& c) : camera(c), undistort(c), raw(c.width, c.height) {
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; ++x)
      raw.at(x, y) = static_cast<std::uint8_t>(128 + 60 * std::sin(0.11 * x + 0.05 * y) + 50 * std::cos(0.13 * y));
  prepare_opencv(*this);
}

namespace {

/// Of this thread's processor time: others may run on this machine meanwhile.
double milliseconds(void (*run)(Problem&), Problem& problem) {
  const auto now = [] {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
  };
  const double begin = now();
  run(problem);
  return now() - begin;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

int largest_difference(const Problem& problem) {
  int largest = 0;
  for (int y = 0; y < problem.camera.height; ++y)
    for (int x = 0; x < problem.camera.width; ++x)
      if (problem.undistort.valid_mask().at(x, y))
        largest = std::max(largest, std::abs(problem.image.at(x, y) - problem.opencv_image.at<std::uint8_t>(y, x)));
  return largest;
}

bool compare(const char* name, const Camera& camera, int repetitions) {
  Problem problem(camera);
  remap_pavo(problem);
  remap_opencv(problem);
  const int difference = largest_difference(problem);
  if (difference > 3) {
    std::printf("%-24s the pictures differ by %d gray levels\n", name, difference);
    return false;
  }
  std::vector<double> pavo_ms, opencv_ms, ratio;
  for (int n = 0; n < repetitions; ++n) {  // alternating, so that both see the same machine
    pavo_ms.push_back(milliseconds(remap_pavo, problem));
    opencv_ms.push_back(milliseconds(remap_opencv, problem));
    ratio.push_back(opencv_ms.back() / pavo_ms.back());
  }
  std::printf("%-24s %4dx%3d  within %d levels   pavo %6.3f ms   opencv %6.3f ms   opencv / pavo %.2f\n", name,
              camera.width, camera.height, difference, median(pavo_ms), median(opencv_ms), median(ratio));
  return true;
}

}  // namespace
}  // namespace pavo::bench

int main(int argc, char** argv) {
  using pavo::Camera;
  using pavo::Lens;
  const int repetitions = argc > 1 ? std::atoi(argv[1]) : 101;
  cv::setNumThreads(1);
  const Camera drone{752, 480, 458.654, 457.296, 367.215, 248.375, Lens::radial_tangential, {-0.2834, 0.0740, 0.0002}};
  const Camera car{1242, 375, 721.5, 721.5, 609.6, 172.9, Lens::radial_tangential, {-0.37, 0.2, 0.0009, 0.0018, -0.07}};
  const Camera fisheye{848, 800, 286, 286, 424, 400, Lens::equidistant, {-0.008, 0.045, -0.042, 0.008}};
  bool same = true;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::GetChosenTarget().Update(target);
    std::printf("%s\n", hwy::TargetName(target));
    same &= pavo::bench::compare("radial-tangential", drone, repetitions);
    same &= pavo::bench::compare("radial-tangential, wide", car, repetitions);
    same &= pavo::bench::compare("fisheye", fisheye, repetitions);
  }
  return same ? 0 : 1;
}
