// The picture that the feature benchmarks look at, and how they take times.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <functional>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <vector>

#include "types/image.h"

namespace pavo::bench {

/// Random boxes on a gradient, softly blurred: corners of all contrasts, as on a street.
inline cv::Mat rendered_texture(int width, int height) {
  std::mt19937 random(1);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  cv::Mat picture(height, width, CV_8U);
  for (int y = 0; y < height; ++y) picture.row(y).setTo(220 - 150 * y / height);
  for (int i = 0; i < 1500; ++i) {
    const cv::Rect box(below(width), height / 4 + below(height), 3 + below(50), 3 + below(40));
    cv::rectangle(picture, box, below(256), cv::FILLED);
  }
  cv::GaussianBlur(picture, picture, {3, 3}, 0.7);
  return picture;
}

/// The image that the first argument names, else frame 100 of kitti05-300 in PAVO_DATA, else a rendered texture.
inline cv::Mat picture(int argc, char** argv) {
  std::string path;
  if (argc > 1) path = argv[1];
  if (const char* data = std::getenv("PAVO_DATA"); path.empty() && data != nullptr && *data != 0) {
    path = (std::filesystem::path(data) / "sequences/kitti05-300/image_0/000100.jpg").string();
  }
  cv::Mat picture = path.empty() ? rendered_texture(1226, 370) : cv::imread(path, cv::IMREAD_GRAYSCALE);
  if (picture.empty()) {
    std::cerr << path << ": expected an image that OpenCV can read; name another one\n";
    std::exit(1);
  }
  std::cout << (path.empty() ? "a rendered texture" : path) << ", " << picture.cols << "x" << picture.rows << "\n";
  return picture;
}

inline Image to_image(const cv::Mat& picture) {
  Image image(picture.cols, picture.rows);
  for (int y = 0; y < picture.rows; ++y)
    std::memcpy(image.row(y), picture.ptr(y), static_cast<std::size_t>(picture.cols));
  return image;
}

/// The calling thread's CPU time: what a busy machine takes away from a long competitor is not counted against it.
inline double thread_cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

/// Runs the competitors in turns, so that whatever else the machine does hits them alike; the medians in milliseconds
/// of CPU time.
inline std::vector<double> median_ms(int rounds, const std::vector<std::function<void()>>& competitors) {
  std::vector<std::vector<double>> times(competitors.size());
  for (int round = -2; round < rounds; ++round) {  // the first two warm up
    for (std::size_t i = 0; i < competitors.size(); ++i) {
      const double start = thread_cpu_ms();
      competitors[i]();
      if (round >= 0) times[i].push_back(thread_cpu_ms() - start);
    }
  }
  std::vector<double> medians;
  for (std::vector<double>& t : times) {
    std::nth_element(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(t.size() / 2), t.end());
    medians.push_back(t[t.size() / 2]);
  }
  return medians;
}

}  // namespace pavo::bench
