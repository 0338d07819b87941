// What do all stages of a rectified frame cost together (features and odometry; no people, no decoding), measured in
// cv::FAST(image, 20, true) on the same image, one thread ("F")?
//
//   bench_stages [FOLDER OF IMAGES] [FEATURES]     default: kitti05-300 in PAVO_DATA, 1500
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "bench/fast/picture.h"
#include "pavo/simd.h"
#include "stages/features/extract.h"
#include "stages/pose/odometry.h"

namespace pavo::bench {
namespace {

constexpr int kFrames = 100;
constexpr Camera kKitti05{.width = 1226, .height = 370, .fx = 707.0912, .fy = 707.0912, .cx = 601.8873, .cy = 183.1104};

std::vector<cv::Mat> frames_of(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  files.resize(std::min<std::size_t>(files.size(), kFrames));
  std::vector<cv::Mat> frames;
  for (const auto& file : files) frames.push_back(cv::imread(file, cv::IMREAD_GRAYSCALE));
  return frames;
}

struct Slot {
  Image image;
  Features features;
};

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

double timed_ms(const std::function<void()>& work) {
  const double start = thread_cpu_ms();
  work();
  return thread_cpu_ms() - start;
}

int run(int argc, char** argv) {
  const char* data = std::getenv("PAVO_DATA");
  const std::filesystem::path folder =
      argc > 1 ? argv[1] : std::string(data ? data : ".") + "/sequences/kitti05-300/image_0";
  if (!std::filesystem::is_directory(folder)) {
    std::fprintf(stderr, "%s: no folder of images; name one, or set PAVO_DATA\n", folder.c_str());
    return 1;
  }
  cv::setNumThreads(1);
  const std::vector<cv::Mat> frames = frames_of(folder);
  FeatureOptions feature_options;
  feature_options.max_features = argc > 2 ? std::atoi(argv[2]) : 1500;
  const ExtractFeatures extract(feature_options, frames.front().cols, frames.front().rows);
  ExtractFeatures::Scratch scratch;
  Odometry odometry(kKitti05, {}, std::make_shared<UnitStep>());
  const People nobody;
  PoseResult pose;
  Slot slots[2];
  std::vector<cv::KeyPoint> corners;
  std::vector<double> fast, features, pose_ms;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    Slot& now = slots[k % 2];
    const Slot& before = slots[(k + 1) % 2];
    now.image = to_image(frames[k]);
    fast.push_back(timed_ms([&] { cv::FAST(frames[k], corners, 20, true); }));
    features.push_back(timed_ms([&] { extract(now.image, now.features, scratch); }));
    pose_ms.push_back(timed_ms([&] {
      const FrameTime time{.index = static_cast<std::int64_t>(k), .t_ns = static_cast<std::int64_t>(k) * 100'000'000};
      const FrameView previous = k > 0 ? FrameView{&before.features, &before.image} : FrameView{};
      odometry(time, {&now.features, &now.image}, previous, nobody, pose);
    }));
    if (pose.quality != Quality::tracked) {
      std::fprintf(stderr, "frame %zu was not tracked: these times would mean nothing\n", k);
      return 1;
    }
  }
  const double F = median(fast), f = median(features), o = median(pose_ms);
  std::printf("%zu frames, up to %d features, %s; medians\n", frames.size(), feature_options.max_features,
              simd_target().c_str());
  std::printf("  cv::FAST  %6.3f ms = F\n  features  %6.3f ms = %.2f F\n  odometry  %6.3f ms = %.2f F\n", F, f, f / F,
              o, o / F);
  std::printf("  sum       %6.3f ms = %.2f F\n", f + o, (f + o) / F);
  return 0;
}

}  // namespace
}  // namespace pavo::bench

int main(int argc, char** argv) {
  return pavo::bench::run(argc, argv);
}
