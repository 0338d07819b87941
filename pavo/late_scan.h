// The scan for people as the engine calls it: half of the sizes in each frame, in turn. Live, a frame that is over its
// latency budget is not scanned, and the people of the frame before are carried on.
#pragma once

#include <functional>
#include <utility>

#include "engine/frame_info.h"
#include "stages/people/scan.h"
#include "stages/people/track_people.h"

namespace pavo {

/// Const-callable by any number of threads, as the scan is. `scanned`: whether the detections are this frame's. Whose
/// turn it is goes by the order of admission, which is the same on every run; frames that are late lose theirs.
struct ScanUnlessLate {
  using Scratch = ScanPeople::Scratch;
  ScanPeople scan;
  bool sizes_in_turn;  ///< false: all of them in each frame

  void operator()(const FrameInfo& info, const Image& image, Detections& detections, bool& scanned,
                  Scratch& scratch) const {
    (*this)(info, image, scan.standing(), detections, scanned, scratch);
  }
  void operator()(const FrameInfo& info, const Image& image, const std::optional<StandingPrior>& standing,
                  Detections& detections, bool& scanned, Scratch& scratch) const {
    scan(image, standing, levels_of(info), detections, scratch);
    scanned = true;
  }
  void late(const Image& image, const std::optional<StandingPrior>&, Detections& detections, bool& scanned) const {
    late(image, detections, scanned);
  }
  void late(const Image&, Detections& detections, bool& scanned) const {
    detections.clear();
    scanned = false;
  }

 private:
  ScanLevels levels_of(const FrameInfo& info) const {
    if (!sizes_in_turn) return ScanLevels::all;
    return info.sequence % 2 == 0 ? ScanLevels::even : ScanLevels::odd;
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
