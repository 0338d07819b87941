// The scan for people as the engine calls it: live, a frame that is over its latency budget is not scanned, and the
// people of the frame before are carried on.
#pragma once

#include <functional>
#include <utility>

#include "stages/people/scan.h"
#include "stages/people/track_people.h"

namespace pavo {

/// Const-callable by any number of threads, as the scan is. `scanned`: whether the detections are this frame's.
struct ScanUnlessLate {
  using Scratch = ScanPeople::Scratch;
  ScanPeople scan;

  void operator()(const Image& image, Detections& detections, bool& scanned, Scratch& scratch) const {
    scan(image, detections, scratch);
    scanned = true;
  }
  void operator()(const Image& image, const std::optional<StandingPrior>& standing, Detections& detections,
                  bool& scanned, Scratch& scratch) const {
    scan(image, standing, detections, scratch);
    scanned = true;
  }
  void late(const Image& image, const std::optional<StandingPrior>&, Detections& detections, bool& scanned) const {
    late(image, detections, scanned);
  }
  void late(const Image&, Detections& detections, bool& scanned) const {
    detections.clear();
    scanned = false;
  }
};

/// In order. Borrows the tracker.
struct TrackUnlessLate {
  TrackPeople& track;

  void operator()(const Detections& detections, const bool& scanned, People& people) {
    if (scanned)
      track(detections, people);
    else
      track.missed(people);
  }
  void missed(People& people) { track.missed(people); }
};

}  // namespace pavo
