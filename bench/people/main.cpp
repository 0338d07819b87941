// How much faster is our scan than cv::HOGDescriptor::detectMultiScale, over the same windows?
#include <hwy/highway.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <opencv2/objdetect.hpp>

#include "bench/fast/picture.h"
#include "bench/people/reference_hog.h"
#include "drivers/models/model_file.h"
#include "stages/people/arena_spread.h"
#include "stages/people/scan_hog.h"
#include "stages/people/scan_opencv.h"

namespace pavo::bench {
namespace {

constexpr double kStep = 1.05;

/// Every window that OpenCV looks at.
std::size_t windows_of_opencv(const cv::Mat& picture) {
  cv::HOGDescriptor hog;
  hog.setSVMDetector(cv::HOGDescriptor::getDefaultPeopleDetector());
  std::vector<cv::Rect> windows;
  hog.detectMultiScale(picture, windows, -1e9, {8, 8}, {}, kStep, 0);
  return windows.size();
}

std::size_t windows_of_ours(const Image& image) {
  hog::Pyramid pyramid;
  pyramid.plan(image.width(), image.height(), kStep, HogTone::square_root);
  std::size_t windows = 0;
  for (const hog::Level& level : pyramid.levels())
    windows += static_cast<std::size_t>(level.windows_x()) * static_cast<std::size_t>(level.windows_y());
  return windows;
}

/// The largest difference of a margin from that of the naive scan in double precision, over some windows of each level.
double difference_from_naive(const Image& image, const PedestrianModel& model) {
  hog::Pyramid pyramid;
  pyramid.plan(image.width(), image.height(), kStep, model.features.tone);
  pyramid.load(image.view());
  const hog::DenseWeights weights(model.weights, model.bias);
  double largest = 0;
  for (std::size_t k = 0; k < pyramid.levels().size(); k += 6) {
    const hog::Level& level = pyramid.levels()[k];
    const test::ReferenceHog naive(test::level_of(image.view(), level, model.features.tone), model.features);
    hog::HogRows rows;
    hog::WindowScores scores;
    rows.start(pyramid, level, model.features);
    scores.start(weights, level.windows_x(), level.windows_y());
    while (rows.next()) {
      scores.add(rows.blocks(), rows.stride());
      for (std::size_t x = 0; x < scores.completed().size(); x += 17) {
        const std::vector<double> d = naive.window(static_cast<int>(x), scores.completed_row());
        double margin = static_cast<double>(model.bias);
        for (std::size_t i = 0; i < d.size(); ++i) margin += d[i] * static_cast<double>(model.weights[i]);
        largest = std::max(largest, std::abs(margin - static_cast<double>(scores.completed()[x])));
      }
    }
  }
  return largest;
}

double wall_ms() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void two_threads(const Image& image, const PedestrianModel& model) {
  tbb::task_arena arena(2);
  ArenaSpread helpers(arena);
  const ScanPeopleHog one(model, {.border_cells = 0}), two(model, {.border_cells = 0, .spread = &helpers});
  ScanPeopleHog::Scratch a, b;
  Detections found;
  std::vector<double> times[2];
  for (int round = 0; round < 101; ++round) {
    const double start = wall_ms();
    one(image, found, a);
    const double middle = wall_ms();
    two(image, found, b);
    times[0].push_back(middle - start);
    times[1].push_back(wall_ms() - middle);
  }
  // The fastest rounds are those in which nobody else needed a core.
  for (auto& t : times) std::sort(t.begin(), t.end());
  std::printf(
      "two threads: %.2f ms with one, %.2f ms with two, ratio %.2f (lower quartiles of 101 alternating rounds, %.2f at "
      "the median)\n",
      times[0][25], times[1][25], times[0][25] / times[1][25], times[0][50] / times[1][50]);
}

int run(int argc, char** argv) {
  cv::setNumThreads(1);
  const cv::Mat theirs = picture(argc, argv);
  const Image ours = to_image(theirs);
  const PedestrianModel model = default_pedestrian_model();
  if (windows_of_opencv(theirs) != windows_of_ours(ours)) {
    std::fprintf(stderr, "OpenCV looks at %zu windows, we at %zu\n", windows_of_opencv(theirs), windows_of_ours(ours));
    return 1;
  }
  const double difference = difference_from_naive(ours, model);
  std::printf("%zu windows, the same as OpenCV's; margins within %.3f of the naive scan in double precision\n",
              windows_of_ours(ours), difference);
  if (!(difference < 0.1)) return 1;

  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().DeInit();
    const ScanPeopleOpencv opencv;
    const ScanPeopleHog hog(model, {.border_cells = 0}), with_border(model);
    ScanPeopleOpencv::Scratch s;
    ScanPeopleHog::Scratch t, u;
    Detections found;
    const std::vector<double> ms = median_ms(
        21, {[&] { opencv(ours, found, s); }, [&] { hog(ours, found, t); }, [&] { with_border(ours, found, u); }});
    std::printf("%-6s OpenCV %.2f ms, ours %.2f ms, ratio %.1f; ours with its border %.2f ms\n",
                hwy::TargetName(target), ms[0], ms[1], ms[0] / ms[1], ms[2]);
    hwy::SetSupportedTargetsForTest(0);
  }
  hwy::GetChosenTarget().DeInit();
  two_threads(ours, model);
  return 0;
}

}  // namespace
}  // namespace pavo::bench

int main(int argc, char** argv) {
  return pavo::bench::run(argc, argv);
}
