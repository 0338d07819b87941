// Matches as pictures.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "stages/matches/matches.h"
#include "types/image.h"

namespace pavo::bench {

/// The current frame, darkened, with a line from where each match was to where it is: green the right ones, red the
/// others, on top.
cv::Mat draw_matches(const Image& current, const PointPairs& pairs, std::span<const std::uint8_t> right);

struct Tile {
  std::string title;
  cv::Mat picture;
};

/// All of them under their titles, two in a row.
cv::Mat contact_sheet(const std::vector<Tile>& tiles);

/// Writes `picture`, or throws std::runtime_error naming the file.
void write_picture(const std::string& path, const cv::Mat& picture);

}  // namespace pavo::bench
