// What competes: a way to find points in two frames and to say which is which.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "stages/features/features.h"
#include "stages/matches/matches.h"
#include "types/image.h"

namespace pavo::bench {

/// At most as many keypoints does a competitor keep.
inline constexpr int kMaxKeypoints = 2000;
/// Nearest over second nearest distance, in each descriptor's own norm.
inline constexpr float kRatio = 0.85f;

/// What was found in one frame. Ours is in `features`, what OpenCV described in the other two.
struct Found {
  Features features;
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;  ///< one row per keypoint
};

struct View {
  const Image& image;
  const Found& found;
};

/// The image's pixels as OpenCV sees them; for reading only.
inline cv::Mat mat_of(const Image& image) {
  return {image.height(), image.width(), CV_8U, const_cast<std::uint8_t*>(image.row(0)),
          static_cast<std::size_t>(image.stride())};
}

/// Owns its working memory: one caller at a time.
class Competitor {
 public:
  virtual ~Competitor() = default;
  virtual std::string name() const = 0;
  /// Only the points.
  virtual void detect(const Image& image, Found& found) = 0;
  /// The points and their descriptors (detection included: most share its scale space with the description).
  virtual void extract(const Image& image, Found& found) = 0;
  virtual void match(const View& previous, const View& current, PointPairs& pairs) = 0;
  virtual std::size_t count(const Found& found) const { return found.keypoints.size(); }
  /// Already matched to a fraction of a pixel by the method itself: nothing is left for RefineSubpixel.
  virtual bool tracks() const { return false; }
};

using Competitors = std::vector<std::unique_ptr<Competitor>>;

// One file each.
void add_fast_surf(Competitors& to);     ///< fast_surf.cpp: pavo's, upright and oriented
void add_corners_surf(Competitors& to);  ///< corners_surf.cpp: OpenCV's corner detectors, pavo's SURF
void add_klt(Competitors& to);           ///< klt.cpp: corners that are followed
void add_orb(Competitors& to);
void add_brisk(Competitors& to);
void add_sift(Competitors& to);
void add_kaze(Competitors& to);
void add_akaze(Competitors& to);

}  // namespace pavo::bench
