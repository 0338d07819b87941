#include "bench/detectors/measure.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/features2d.hpp>
#include <stdexcept>

#include "bench/detectors/judge.h"
#include "bench/fast/picture.h"
#include "stages/matches/refine_subpixel.h"

namespace pavo::bench {
namespace {

template <class Work>
double timed_ms(const Work& work) {
  const double start = thread_cpu_ms();
  work();
  return thread_cpu_ms() - start;
}

// The first call brings the image back into the caches that another competitor has taken.
double fast_ms(const Image& image) {
  std::vector<cv::KeyPoint> corners;
  cv::FAST(mat_of(image), corners, 20, true);
  return timed_ms([&] { cv::FAST(mat_of(image), corners, 20, true); });
}

double right_percent(const PointPairs& pairs, const DataSet& set, const FramePair& pair) {
  if (pairs.empty()) return 0;
  double right = 0;
  for (const std::uint8_t is : right_ones(pairs, set.camera, pair.T_c_p)) right += is;
  return 100 * right / static_cast<double>(pairs.size());
}

void refine(const FramePair& pair, PointPairs& pairs) {
  std::vector<std::uint8_t> refined(pairs.size());
  RefineSubpixel()(pair.previous.view(), pair.current.view(), pairs, refined);
}

}  // namespace

PointPairs check(Competitor& competitor, const DataSet& set, const FramePair& pair) {
  Found previous, current;
  competitor.extract(pair.previous, previous);
  competitor.extract(pair.current, current);
  PointPairs pairs;
  competitor.match({pair.previous, previous}, {pair.current, current}, pairs);
  if (pairs.empty()) throw std::runtime_error(competitor.name() + ": no match between two frames of " + set.name);
  for (const PointPair& p : pairs) {
    const auto inside = [&](float x, float y) {
      return x >= 0 && y >= 0 && x < static_cast<float>(set.camera.width) && y < static_cast<float>(set.camera.height);
    };
    if (!inside(p.x_previous, p.y_previous) || !inside(p.x_current, p.y_current))
      throw std::runtime_error(competitor.name() + ": a match outside the image in " + set.name);
  }
  return pairs;
}

void measure(Competitor& competitor, const DataSet& set, const FramePair& pair, Times& times, Figures& figures) {
  Found previous, current;
  competitor.extract(pair.previous, previous);
  PointPairs pairs;
  const double F = fast_ms(pair.current);
  times.fast_ms.push_back(F);
  times.detect.push_back(timed_ms([&] { competitor.detect(pair.current, current); }) / F);
  times.extract.push_back(timed_ms([&] { competitor.extract(pair.current, current); }) / F);
  times.describe.push_back(times.extract.back() - times.detect.back());
  times.match.push_back(timed_ms([&] {
                          competitor.match({pair.previous, previous}, {pair.current, current}, pairs);
                        }) /
                        F);

  figures.pairs++;
  figures.keypoints.push_back(static_cast<double>(competitor.count(current)));
  figures.matches.push_back(static_cast<double>(pairs.size()));
  figures.right_percent.push_back(right_percent(pairs, set, pair));
  const MotionError raw = motion_error(pairs, set.camera, pair);
  if (raw.found) figures.direction_deg.push_back(raw.direction_deg);
  if (!competitor.tracks()) times.refine.push_back(timed_ms([&] { refine(pair, pairs); }) / F);
  const MotionError refined = competitor.tracks() ? raw : motion_error(pairs, set.camera, pair);
  figures.right_percent_refined.push_back(right_percent(pairs, set, pair));
  figures.lost += !refined.found;
  if (!refined.found) return;
  figures.direction_deg_refined.push_back(refined.direction_deg);
  figures.rotation_deg_refined.push_back(refined.rotation_deg);
}

void print_times(const Competitors& competitors, const std::vector<Times>& times) {
  std::printf("| | detect | describe | match | together | sub-pixel |\n| --- | ---: | ---: | ---: | ---: | ---: |\n");
  for (std::size_t i = 0; i < competitors.size(); ++i) {
    const double detect = median(times[i].detect), extract = median(times[i].extract), match = median(times[i].match);
    std::printf("| %s | %.1f | ", competitors[i]->name().c_str(), detect);
    if (competitors[i]->tracks())
      std::printf("- | %.1f | %.1f | - |\n", match, detect + match);
    else
      std::printf("%.1f | %.1f | %.1f | %.1f |\n", std::max(0.0, median(times[i].describe)), match, extract + match,
                  median(times[i].refine));
  }
}

void print_figures(const Competitors& competitors, const DataSet& set, const std::vector<Figures>& figures) {
  std::printf("\n**%s**, %d pairs of frames\n\n", set.name.c_str(), figures.front().pairs);
  std::printf(
      "| | keypoints | matches | right %% | refined | direction deg | refined | 90 %% | rotation deg | lost |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  for (std::size_t i = 0; i < competitors.size(); ++i) {
    const Figures& f = figures[i];
    std::printf("| %s | %.0f | %.0f | %.1f | ", competitors[i]->name().c_str(), median(f.keypoints), median(f.matches),
                median(f.right_percent));
    if (competitors[i]->tracks())
      std::printf("- | %.2f | - | ", median(f.direction_deg));
    else
      std::printf("%.1f | %.2f | %.2f | ", median(f.right_percent_refined), median(f.direction_deg),
                  median(f.direction_deg_refined));
    std::printf("%.2f | %.3f | %d |\n", quantile(f.direction_deg_refined, 0.9), median(f.rotation_deg_refined), f.lost);
  }
}

}  // namespace pavo::bench
