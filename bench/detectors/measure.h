// What is measured of one competitor.
#pragma once

#include <string>
#include <vector>

#include "bench/detectors/competitor.h"
#include "bench/detectors/frame_pairs.h"

namespace pavo::bench {

/// In cv::FAST(image, 20, true) on the same image, taken right before: one value per frame pair.
struct Times {
  std::vector<double> fast_ms, detect, extract, match, refine;
  std::vector<double> describe;  ///< extract - detect
};

/// Of one data set, one value per frame pair; the motions where one was found.
struct Figures {
  std::vector<double> keypoints, matches, right_percent, right_percent_refined;
  std::vector<double> direction_deg, direction_deg_refined, rotation_deg_refined;
  int pairs = 0, lost = 0;  ///< lost: no motion from the refined matches
};

/// Throws std::runtime_error, naming the competitor, when it finds nothing or what it finds is not finite.
PointPairs check(Competitor& competitor, const DataSet& set, const FramePair& pair);

void measure(Competitor& competitor, const DataSet& set, const FramePair& pair, Times& times, Figures& figures);

/// Markdown.
void print_times(const Competitors& competitors, const std::vector<Times>& times);
void print_figures(const Competitors& competitors, const DataSet& set, const std::vector<Figures>& figures);

}  // namespace pavo::bench
