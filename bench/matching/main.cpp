// How long do exact mutual nearest neighbours take, beside OpenCV's brute force matcher? First: do both find the same
// pairs?
#include "bench/matching/competitors.h"

#include <opencv2/core.hpp>

#include <hwy/highway.h>
#include <time.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace pavo;
using namespace pavo::bench;

/// Unit vectors around `clusters` centres, as the descriptors of real corners are; 0 = spread over the whole sphere.
Features unit_descriptors(std::size_t n, std::size_t clusters, std::uint32_t seed) {
  std::mt19937 centres(1), random(seed);
  std::normal_distribution<float> normal;
  std::vector<float> centre(clusters * Features::kDescriptorSize);
  for (float& value : centre) value = normal(centres);
  Features features;
  features.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    features.keypoints.push_back({});
    float* d = features.descriptor(i);
    float norm2 = 0;
    const std::size_t c = clusters ? random() % clusters : 0;
    for (std::size_t k = 0; k < Features::kDescriptorSize; ++k) {
      d[k] = clusters ? centre[c * Features::kDescriptorSize + k] + 0.4f * normal(random) : normal(random);
      norm2 += d[k] * d[k];
    }
    for (int k = 0; k < Features::kDescriptorSize; ++k) d[k] /= std::sqrt(norm2);
  }
  return features;
}

/// Of this thread's processor time: others may run on this machine meanwhile.
double milliseconds(void (*run)(Problem&, Pairs&), Problem& problem, Pairs& pairs) {
  const auto now = [] {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
  };
  const double begin = now();
  run(problem, pairs);
  return now() - begin;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

bool compare(const char* name, const Features& previous, const Features& current, int repetitions) {
  Problem problem{previous, current, {}, {}};
  Pairs ours, theirs;
  match_pavo(problem, ours);
  match_opencv(problem, theirs);
  if (ours != theirs) {
    std::printf("%-28s the pairs differ: %zu and %zu\n", name, ours.size(), theirs.size());
    return false;
  }
  std::vector<double> pavo_ms, opencv_ms, ratio;
  for (int n = 0; n < repetitions; ++n) {  // alternating, so that both see the same machine
    pavo_ms.push_back(milliseconds(match_pavo, problem, ours));
    opencv_ms.push_back(milliseconds(match_opencv, problem, theirs));
    ratio.push_back(opencv_ms.back() / pavo_ms.back());
  }
  std::printf("%-28s %4zu x %4zu  %4zu pairs, the same   pavo %7.3f ms   opencv %8.3f ms   opencv / pavo %.1f\n", name,
              previous.size(), current.size(), ours.size(), median(pavo_ms), median(opencv_ms), median(ratio));
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  const int repetitions = argc > 1 ? std::atoi(argv[1]) : 25;
  cv::setNumThreads(1);
  bool same = true;
  const std::optional<Frames> frames = real_frames();
  if (!frames) std::printf("without real frames: set PAVO_DATA to the folder with the recorded sequences\n");
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::GetChosenTarget().Update(target);
    std::printf("%s\n", hwy::TargetName(target));
    for (const std::size_t n : {500UL, 1500UL, 2000UL})
      same &= compare("random unit vectors", unit_descriptors(n, 0, 2), unit_descriptors(n, 0, 3), repetitions);
    same &= compare("in 200 clusters", unit_descriptors(1500, 200, 2), unit_descriptors(1500, 200, 3), repetitions);
    if (frames) same &= compare("two frames of kitti05-300", frames->previous, frames->current, repetitions);
  }
  return same ? 0 : 1;
}
