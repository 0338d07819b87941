// The naive scan in double precision as a detector: what does the integer arithmetic of the fast one cost?
//
//     bench_people_reference IMAGE... > reference.csv     (seconds an image)
//     lamr.py SETS --against ...                          (the paired difference)
#include <cstdio>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "bench/fast/picture.h"
#include "bench/people/reference_hog.h"
#include "drivers/models/model_file.h"
#include "stages/people/person_window.h"
#include "stages/people/scan_hog.h"
#include "stages/people/suppress.h"

namespace pavo::bench {
namespace {

constexpr double kLowestMargin = -1.5;

/// All blocks of a level, so that windows share them.
std::vector<std::vector<double>> blocks_of(const test::ReferenceHog& hog) {
  std::vector<std::vector<double>> blocks;
  for (int y = 0; y + 1 < hog.cells_y(); ++y)
    for (int x = 0; x + 1 < hog.cells_x(); ++x) blocks.push_back(hog.block(x, y));
  return blocks;
}

double margin_of(const std::vector<std::vector<double>>& blocks, int stride, int x, int y,
                 const PedestrianModel& model) {
  double margin = static_cast<double>(model.bias);
  std::size_t i = 0;
  for (int by = 0; by < hog::kBlocksY; ++by)
    for (int bx = 0; bx < hog::kBlocksX; ++bx)
      for (const double v : blocks[static_cast<std::size_t>((y + by) * stride + x + bx)])
        margin += v * static_cast<double>(model.weights[i++]);
  return margin;
}

Detections scan(const Image& image, const PedestrianModel& model) {
  hog::Pyramid pyramid;
  pyramid.plan(image.width(), image.height(), ScanHogOptions{}.scale_step, model.features.tone,
               hog::Sampling::as_soft_as_training, ScanHogOptions{}.border_cells * hog::kCell);
  Detections found;
  for (const hog::Level& level : pyramid.levels()) {
    const test::ReferenceHog hog(test::level_of(image.view(), level, model.features.tone), model.features);
    const std::vector<std::vector<double>> blocks = blocks_of(hog);
    for (int y = 0; y < level.windows_y(); ++y)
      for (int x = 0; x < level.windows_x(); ++x) {
        const double margin = margin_of(blocks, hog.cells_x() - 1, x, y, model);
        if (margin < kLowestMargin) continue;
        found.push_back(person_in_window(static_cast<float>(level.image_x(x)), static_cast<float>(level.image_y(y)),
                                         static_cast<float>(64 * level.step_x), static_cast<float>(128 * level.step_y),
                                         static_cast<float>(model.probability(margin))));
      }
  }
  suppress_non_maxima(found, ScanHogOptions{}.largest_share);
  return found;
}

}  // namespace
}  // namespace pavo::bench

int main(int argc, char** argv) {
  const pavo::PedestrianModel model = pavo::default_pedestrian_model();
  std::printf("image,x,y,width,height,score\n");
  for (int i = 1; i < argc; ++i) {
    const cv::Mat picture = cv::imread(argv[i], cv::IMREAD_GRAYSCALE);
    if (picture.empty()) {
      std::fprintf(stderr, "%s: expected an image\n", argv[i]);
      return 1;
    }
    for (const pavo::PersonBox& p : pavo::bench::scan(pavo::bench::to_image(picture), model))
      std::printf("%s,%.1f,%.1f,%.1f,%.1f,%.6f\n", std::filesystem::path(argv[i]).filename().c_str(),
                  static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.width),
                  static_cast<double>(p.height), static_cast<double>(p.score));
    std::fflush(stdout);
  }
  return 0;
}
