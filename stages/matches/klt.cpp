#include "stages/matches/klt.h"

#include <opencv2/core.hpp>
#include <opencv2/video/tracking.hpp>
#include <stdexcept>
#include <string>

namespace pavo {
namespace {

void require(bool ok, const char* option, const std::string& expected, const std::string& value) {
  if (!ok) throw std::invalid_argument(std::string("klt: ") + option + " must be " + expected + ", is " + value);
}

/// OpenCV reads the pixels where they are.
cv::Mat borrowed(const Image& image) {
  return cv::Mat(image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.row(0)),
                 static_cast<std::size_t>(image.stride()));
}

std::string size_of(const Image& image) {
  return std::to_string(image.width()) + "x" + std::to_string(image.height());
}

bool closer_than(const cv::Point2f& a, const cv::Point2f& b, float limit) {
  const float dx = a.x - b.x, dy = a.y - b.y;
  return dx * dx + dy * dy <= limit * limit;
}

bool inside(const cv::Point2f& p, const Image& image) {
  return p.x >= 0 && p.y >= 0 && p.x <= static_cast<float>(image.width() - 1) &&
         p.y <= static_cast<float>(image.height() - 1);
}

}  // namespace

TrackKlt::TrackKlt(const Options& o) : options_(o) {
  require(o.window_px >= 3 && o.window_px % 2 == 1, "window_px", "odd and at least 3", std::to_string(o.window_px));
  require(o.levels >= 1 && o.levels <= 16, "levels", "1 to 16", std::to_string(o.levels));
  require(o.iterations >= 1, "iterations", "at least 1", std::to_string(o.iterations));
  require(o.epsilon_px > 0, "epsilon_px", "above 0", std::to_string(o.epsilon_px));
  require(o.max_return_px >= 0, "max_return_px", "0 (off) or more", std::to_string(o.max_return_px));
  require(o.min_eigenvalue >= 0, "min_eigenvalue", "0 or more", std::to_string(o.min_eigenvalue));
  require(o.max_displacement_px >= 0, "max_displacement_px", "0 (off) or more", std::to_string(o.max_displacement_px));
}

void TrackKlt::operator()(const Image& previous, const Image& current, std::span<const Keypoint> keypoints,
                          std::span<const std::uint8_t> keep, Tracks& out, Scratch& s) const {
  out.pairs.clear();
  out.previous.clear();
  if (previous.width() != current.width() || previous.height() != current.height())
    throw std::runtime_error("klt: the previous image is " + size_of(previous) + " and the current one " +
                             size_of(current) + "; both must have the same size");
  if (!keep.empty() && keep.size() != keypoints.size())
    throw std::invalid_argument("klt: " + std::to_string(keep.size()) + " keep flags for " +
                                std::to_string(keypoints.size()) + " keypoints; expected one for each, or none at all");
  s.points.clear();
  s.index.clear();
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    if (!keep.empty() && keep[i] == 0) continue;
    s.points.emplace_back(keypoints[i].x, keypoints[i].y);
    s.index.push_back(static_cast<int>(i));
  }
  if (s.points.empty() || previous.empty()) return;

  // One pyramid with derivatives for each image serves both directions.
  const cv::Size window(options_.window_px, options_.window_px);
  const int top = options_.levels - 1;
  const int top_previous = cv::buildOpticalFlowPyramid(borrowed(previous), s.pyramid_previous, window, top);
  const int top_current = cv::buildOpticalFlowPyramid(borrowed(current), s.pyramid_current, window, top);
  const int levels = std::min(top_previous, top_current);
  const cv::TermCriteria criteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, options_.iterations,
                                  static_cast<double>(options_.epsilon_px));
  const auto min_eigenvalue = static_cast<double>(options_.min_eigenvalue);
  cv::calcOpticalFlowPyrLK(s.pyramid_previous, s.pyramid_current, s.points, s.forward, s.found, s.error, window, levels,
                           criteria, 0, min_eigenvalue);
  const bool check_back = options_.max_return_px > 0;
  if (check_back)
    cv::calcOpticalFlowPyrLK(s.pyramid_current, s.pyramid_previous, s.forward, s.backward, s.found_back, s.error,
                             window, levels, criteria, 0, min_eigenvalue);

  for (std::size_t i = 0; i < s.points.size(); ++i) {
    const cv::Point2f from = s.points[i], to = s.forward[i];
    if (!s.found[i] || !inside(to, current)) continue;
    if (check_back && !(s.found_back[i] && closer_than(from, s.backward[i], options_.max_return_px))) continue;
    if (options_.max_displacement_px > 0 && !closer_than(from, to, options_.max_displacement_px)) continue;
    out.pairs.push_back({from.x, from.y, to.x, to.y});
    out.previous.push_back(s.index[i]);
  }
}

}  // namespace pavo
