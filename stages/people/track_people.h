// The in-order stage `people`: detections carried from frame to frame, so that a person whom the scan misses for a
// moment stays known, and their features do not flash back into the odometry.
#pragma once

#include <vector>

#include "stages/people/people.h"

namespace pavo {

struct TrackPeopleOptions {
  float birth_score = 0;       ///< a detection below this continues a track, but begins none
  float match_overlap = 0.3f;  ///< smallest intersection over union of a prediction and its detection
  int confirm_hits = 3;        ///< from so many detections on, a person is believed longer
  int tentative_misses = 1;    ///< frames without a detection that an unconfirmed person survives
  int confirmed_misses = 6;    ///< the same for a confirmed one (0.6 s at 10 Hz), and
  int longest_misses = 20;     ///< for one who was seen at least so often (2 s at 10 Hz)
  float position_gain = 0.7f;  ///< share of the innovation that goes into the box (alpha), 0 to 1
  float velocity_gain = 0.3f;  ///< ... and into its velocity (beta), 0 to 1
};

/// Each person is a box (centre, width, height) with a constant velocity in the image, in pixels per frame, followed by
/// an alpha-beta filter (a steady-state Kalman filter; Benedict and Bordner, 1962).
///
/// The rules:
/// - Prediction: every box moves on by its velocity.
/// - Match: pairs of prediction and detection are taken by falling overlap (ties: older person, then better detection),
///   each at most once, down to `match_overlap`.
/// - Birth: a detection without a partner begins a person at once if its score is at least `birth_score`. At once,
///   because a false alarm costs a few features of the background, a person who is seen too late costs the pose. Weaker
///   detections continue a person (Zhang et al., ByteTrack, ECCV 2022). By default there are none: what is weaker than
///   a tenth sure pulls boxes away as often as it holds them (docs/benchmarks.md).
/// - Confirmation: after `confirm_hits` detections.
/// - Death: after more than `tentative_misses` frames in a row without a detection (unconfirmed). A confirmed person is
///   believed for as many frames as they were seen, from `confirmed_misses` up to `longest_misses`: who walked along
///   for seconds has not gone because the scan loses them for one, and has a velocity that is known well enough. At
///   once when the box has shrunk to nothing.
/// - Frames that were not scanned (missed()) carry the boxes on and count as frames without a detection: a box that
///   nobody has confirmed for long is a guess, whatever the reason.
///
/// In order, one thread at a time. Allocates only when more people are in the picture than ever before.
class TrackPeople {
 public:
  /// Throws std::invalid_argument if an option is out of its range.
  explicit TrackPeople(const TrackPeopleOptions& options = {});

  /// The detections of the next frame, any order, and who is there: pixels, oldest person first. A person's score is
  /// that of their last detection.
  void operator()(const Detections& detections, People& people);

  /// The next frame was not scanned (it failed, or there was no time): the boxes are carried on.
  void missed(People& people);

  /// Forgets everybody: the next frame does not follow the last one.
  void reset() { tracks_.clear(); }

 private:
  struct State {
    float center_x, center_y, width, height;
  };
  struct Track {
    State box;
    State velocity;
    float score;
    int hits;
    int misses;  // in a row
  };
  struct Pair {
    float overlap;
    int track;
    int detection;
  };

  void predict();
  void match(const Detections& detections);
  void correct(Track& track, const PersonBox& detection) const;
  void bury_the_dead();
  void report(People& people) const;

  TrackPeopleOptions options_;
  std::vector<Track> tracks_;
  std::vector<Pair> pairs_;
  std::vector<int> partner_of_track_;
  std::vector<int> partner_of_detection_;
};

}  // namespace pavo
