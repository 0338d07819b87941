// How long does RANSAC take to be 99.9 % sure, with 40 % outliers among 1000 matches? Measured in F, the time of
// cv::FAST(image, 20, nms) on the picture that is given (one thread). First: does it find the camera's motion?
#include <hwy/highway.h>
#include <time.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "bench/ransac/competitors.h"
#include "stages/pose/essential.h"

namespace {

using namespace pavo;
using namespace pavo::bench;

const Camera kCamera{1226, 370, 707, 707, 602, 183};
constexpr double kNoisePx = 0.3;

double gauss(Random& random) {
  return std::sqrt(-2 * std::log(1 - random.uniform())) * std::cos(6.283185307179586 * random.uniform());
}

Eigen::Vector2d project(const Eigen::Vector3d& p) {
  return {kCamera.fx * p.x() / p.z() + kCamera.cx, kCamera.fy * p.y() / p.z() + kCamera.cy};
}

bool inside(const Eigen::Vector2d& x) {
  return x.x() >= 0 && x.y() >= 0 && x.x() < kCamera.width && x.y() < kCamera.height;
}

/// A street: points 4 to 60 m in front, seen by a camera that drives and turns a little; the rest are false matches.
PointPairs street(std::size_t n, double outlier_share, const SE3& T_c_p, Random random) {
  PointPairs pairs;
  while (pairs.size() < n) {
    const double z = 4 + 56 * random.uniform();
    const Eigen::Vector2d x(random.uniform() * kCamera.width, random.uniform() * kCamera.height);
    Eigen::Vector2d y = project(
        T_c_p * Eigen::Vector3d((x.x() - kCamera.cx) / kCamera.fx * z, (x.y() - kCamera.cy) / kCamera.fy * z, z));
    if (!inside(y)) continue;
    if (static_cast<double>(pairs.size()) < outlier_share * static_cast<double>(n))
      y = {random.uniform() * kCamera.width, random.uniform() * kCamera.height};
    else
      y += kNoisePx * Eigen::Vector2d(gauss(random), gauss(random));
    pairs.push_back(
        {static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(y.x()), static_cast<float>(y.y())});
  }
  for (std::size_t i = n; i > 1; --i) std::swap(pairs[i - 1], pairs[random.below(static_cast<std::uint32_t>(i))]);
  return pairs;
}

/// Angles between the estimated and the true direction and rotation.
struct Error {
  double direction_deg, rotation_deg;
};
Error error_of(const Solution& solution, const PointPairs& pairs, const SE3& truth) {
  const SE3 T =
      motion_in_front(essential_from_fundamental(solution.F, kCamera), pairs, solution.is_inlier, kCamera, 0.5).T_c_p;
  constexpr double kDegrees = 57.29577951308232;
  return {kDegrees * std::acos(std::clamp(T.t.normalized().dot(truth.t.normalized()), -1.0, 1.0)),
          kDegrees * Eigen::AngleAxisd(T.R.transpose() * truth.R).angle()};
}

/// Of this thread's processor time: others may run on this machine meanwhile.
template <class Run>
double milliseconds(const Run& run) {
  const auto now = [] {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
  };
  const double begin = now();
  run();
  return now() - begin;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

bool compare(double outlier_share, const cv::Mat& image, int repetitions) {
  const SE3 truth{Eigen::AngleAxisd(0.02, Eigen::Vector3d(0.2, 0.95, 0.1).normalized()).toRotationMatrix(),
                  Eigen::Vector3d(0.05, 0.02, -0.8)};
  std::vector<double> ours_ms, theirs_ms, in_f, ours_deg, theirs_deg, iterations;
  Problem problem;
  Solution ours, theirs;
  std::vector<cv::KeyPoint> corners;
  for (int n = 0; n < repetitions; ++n) {  // alternating, so that all see the same machine
    problem.seed = static_cast<std::uint64_t>(n);
    problem.pairs = street(1000, outlier_share, truth, Random(static_cast<std::uint64_t>(1000 + n)));
    ours_ms.push_back(milliseconds([&] { ransac_pavo(problem, ours); }));
    theirs_ms.push_back(milliseconds([&] { ransac_opencv(problem, theirs); }));
    if (!image.empty()) in_f.push_back(ours_ms.back() / milliseconds([&] { cv::FAST(image, corners, 20, true); }));
    ours_deg.push_back(error_of(ours, problem.pairs, truth).direction_deg);
    theirs_deg.push_back(error_of(theirs, problem.pairs, truth).direction_deg);
    iterations.push_back(ours.iterations);
    if (ours_deg.back() > 10 || error_of(ours, problem.pairs, truth).rotation_deg > 1) {
      std::printf("outliers %2.0f %%, run %d: wrong by %.1f degrees\n", 100 * outlier_share, n, ours_deg.back());
      return false;
    }
  }
  std::printf(
      "outliers %2.0f %%  pavo %6.3f ms, %4.0f samples, direction within %.2f deg   "
      "opencv %7.3f ms, %.2f deg   opencv / pavo %.1f",
      100 * outlier_share, median(ours_ms), median(iterations), median(ours_deg), median(theirs_ms), median(theirs_deg),
      median(theirs_ms) / median(ours_ms));
  if (!in_f.empty()) std::printf("   pavo %.2f F", median(in_f));
  std::printf("\n");
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  const cv::Mat image = argc > 1 ? cv::imread(argv[1], cv::IMREAD_GRAYSCALE) : cv::Mat();
  if (image.empty()) std::printf("usage: bench_ransac IMAGE [REPETITIONS]; without an image nothing is told in F\n");
  const int repetitions = argc > 2 ? std::max(1, std::atoi(argv[2])) : 101;
  bool right = true;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::GetChosenTarget().Update(target);
    std::printf("%s\n", hwy::TargetName(target));
    for (const double outlier_share : {0.1, 0.4, 0.5}) right &= compare(outlier_share, image, repetitions);
  }
  return right ? 0 : 1;
}
