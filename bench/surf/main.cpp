// How long do SURF-64 descriptors of 1500 keypoints take, measured in cv::FAST(image, 20, true) on one thread ("F")?
#include <hwy/highway.h>
#include <cmath>
#include <cstdio>
#include <opencv2/features2d.hpp>

#include "bench/fast/picture.h"
#include "bench/surf/reference.h"
#include "stages/features/extract.h"
#include "stages/features/fast.h"
#include "stages/features/surf.h"

namespace pavo::bench {
namespace {

constexpr std::size_t kKeypoints = 1500;

/// Compares with the reference descriptors; without them there is nothing to check.
bool agrees_with_reference(int size, bool oriented) {
  const char* variable = std::getenv("PAVO_DATA");
  const std::filesystem::path data(variable != nullptr ? variable : "");
  const std::string name = std::string(oriented ? "oriented" : "upright") + "-size" + std::to_string(size) + ".txt";
  const Reference reference = read_reference(data / "surf" / name);
  if (reference.keypoints.empty()) {
    std::printf("%s is not in PAVO_DATA: not compared\n", name.c_str());
    return true;
  }
  const cv::Mat picture =
      cv::imread((data / "sequences/kitti05-300/image_0/000100.jpg").string(), cv::IMREAD_GRAYSCALE);
  Features features;
  features.reserve(reference.keypoints.size());
  features.keypoints = reference.keypoints;
  Surf::Scratch scratch;
  Surf(size, oriented)(to_image(picture).view(), features, scratch);
  const Agreement found = agreement(reference, features);
  const double fifth_percentile = found.cosines[found.cosines.size() / 20];
  std::printf("%-18s cosine with the reference: least %.5f, 5th percentile %.5f, median %.5f; same nearest %.1f %%\n",
              name.c_str(), found.cosines.front(), fifth_percentile, found.cosines[found.cosines.size() / 2],
              100 * found.same_nearest);
  return (oriented ? fifth_percentile >= 0.95 : found.cosines.front() >= 0.98) && found.same_nearest >= 0.97;
}

/// The strongest corners that have room for a whole window, in raster order.
std::vector<Keypoint> keypoints_of(const Image& image) {
  constexpr int margin = 45;
  FastScratch scratch;
  std::vector<Corner> corners;
  for (const Corner& c : detect_fast(image.view(), 10, scratch)) {
    if (c.x >= margin && c.y >= margin && c.x + margin < image.width() && c.y + margin < image.height()) {
      corners.push_back(c);
    }
  }
  std::stable_sort(corners.begin(), corners.end(), [](Corner a, Corner b) { return a.score > b.score; });
  if (corners.size() > kKeypoints) corners.resize(kKeypoints);
  std::sort(corners.begin(), corners.end(),
            [](Corner a, Corner b) { return std::pair(a.y, a.x) < std::pair(b.y, b.x); });
  std::vector<Keypoint> keypoints;
  for (const Corner& c : corners) keypoints.push_back({static_cast<float>(c.x), static_cast<float>(c.y), 0, 0});
  return keypoints;
}

void compare_descriptors(const cv::Mat& picture, const Image& image, const std::vector<Keypoint>& keypoints) {
  std::vector<cv::KeyPoint> corners;
  std::vector<std::function<void()>> competitors{[&] { cv::FAST(picture, corners, 20, true); }};
  struct Case {
    int size;
    bool oriented;
    Surf surf;
  };
  std::vector<Case> cases;
  for (int size : {9, 20}) {
    for (bool oriented : {false, true}) cases.push_back({size, oriented, Surf(size, oriented)});
  }
  Features features;
  features.reserve(keypoints.size());
  features.keypoints = keypoints;
  Surf::Scratch scratch;
  for (const Case& c : cases) competitors.emplace_back([&] { c.surf(image.view(), features, scratch); });
  const std::vector<double> ms = median_ms(101, competitors);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    std::printf("  size %2d, %-8s: %6.3f ms, F %6.3f ms, ratio %.2f\n", cases[i].size,
                cases[i].oriented ? "oriented" : "upright", ms[i + 1], ms[0], ms[i + 1] / ms[0]);
  }
}

/// The whole stage: corners, grid, descriptors.
void compare_stage(const cv::Mat& picture, const Image& image, int max_features) {
  std::vector<cv::KeyPoint> corners;
  std::vector<std::function<void()>> competitors{[&] { cv::FAST(picture, corners, 20, true); }};
  std::vector<ExtractFeatures> stages;
  for (bool oriented : {false, true}) {
    stages.emplace_back(FeatureOptions{.max_features = max_features, .oriented = oriented}, image.width(),
                        image.height());
  }
  ExtractFeatures::Scratch scratch;
  Features features;
  for (const ExtractFeatures& stage : stages) competitors.emplace_back([&] { stage(image, features, scratch); });
  const std::vector<double> ms = median_ms(101, competitors);
  for (std::size_t i = 0; i < stages.size(); ++i) {
    std::printf("  whole stage, %s, %zu features: %6.3f ms, F %6.3f ms, ratio %.2f, %.0f features/ms\n",
                stages[i].options().oriented ? "oriented" : "upright", features.size(), ms[i + 1], ms[0],
                ms[i + 1] / ms[0], static_cast<double>(features.size()) / ms[i + 1]);
  }
}

int run(int argc, char** argv) {
  cv::setNumThreads(1);
  const cv::Mat theirs = picture(argc, argv);
  const Image ours = to_image(theirs);
  bool good = true;
  for (int size : {9, 20}) {
    for (bool oriented : {false, true}) good = agrees_with_reference(size, oriented) && good;
  }
  if (!good) {
    std::fprintf(stderr, "the descriptors are not close enough to the reference's\n");
    return 1;
  }
  const std::vector<Keypoint> keypoints = keypoints_of(ours);
  std::printf("%zu keypoints\n", keypoints.size());
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().DeInit();
    std::printf("%s\n", hwy::TargetName(target));
    compare_descriptors(theirs, ours, keypoints);
    for (int max_features : {1500, 2000}) compare_stage(theirs, ours, max_features);
    hwy::SetSupportedTargetsForTest(0);
  }
  return 0;
}

}  // namespace
}  // namespace pavo::bench

int main(int argc, char** argv) {
  return pavo::bench::run(argc, argv);
}
