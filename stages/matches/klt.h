// The other way to find the keypoints of the previous frame again: follow them (KLT).
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

#include "stages/features/features.h"
#include "stages/matches/matches.h"
#include "types/image.h"

namespace pavo {

/// What was followed: pairs[n] is the keypoint previous[n] of the previous frame and where it is now.
struct Tracks {
  PointPairs pairs;
  std::vector<int> previous;  ///< index into the previous frame's keypoints, ascending
};

/// Pyramidal Lucas-Kanade (Bouguet 2001; OpenCV's) with the forward-backward check (Kalal, Mikolajczyk, Matas, ICPR
/// 2010): a track is kept when following it back ends within `max_return_px` of where it began.
///
/// Pure, so that any thread may call it with a Scratch of its own. OpenCV allocates inside (its threads are the
/// caller's to turn off, with cv::setNumThreads); our own memory is the Scratch's and grows only.
class TrackKlt {
 public:
  struct Options {
    int window_px = 21;             ///< side of the square window, odd, at least 3
    int levels = 4;                 ///< of the pyramid, the full image included, at least 1
    int iterations = 30;            ///< per level and point, at least 1
    float epsilon_px = 0.01f;       ///< a step shorter than this ends the iteration
    float max_return_px = 0.5f;     ///< forward-backward error; 0 = no check back
    float min_eigenvalue = 1e-4f;   ///< of the 2x2 gradient matrix per pixel of the window (OpenCV's normalisation)
    float max_displacement_px = 0;  ///< longer tracks are dropped; 0 = off
  };
  struct Scratch {
    std::vector<cv::Mat> pyramid_previous, pyramid_current;
    std::vector<cv::Point2f> points, forward, backward;
    std::vector<int> index;
    std::vector<std::uint8_t> found, found_back;
    std::vector<float> error;
  };

  TrackKlt() : TrackKlt(Options{}) {}
  /// Throws std::invalid_argument, naming the option, when one is out of its range.
  explicit TrackKlt(const Options& options);

  /// `keep`: one flag per keypoint, 0 = don't follow it; empty keeps all. `out` is replaced. Throws std::runtime_error
  /// when the images' sizes differ, std::invalid_argument when `keep` has another length than the keypoints.
  void operator()(const Image& previous, const Image& current, std::span<const Keypoint> keypoints,
                  std::span<const std::uint8_t> keep, Tracks& out, Scratch& scratch) const;

 private:
  Options options_;
};

}  // namespace pavo
