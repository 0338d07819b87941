// What all competitors with pavo's descriptors share: pavo's matcher.
#pragma once

#include "bench/detectors/competitor.h"
#include "stages/matches/nearest.h"

namespace pavo::bench {

class SurfFeatures : public Competitor {
 public:
  void match(const View& previous, const View& current, PointPairs& pairs) override {
    match_nearest_(previous.found.features, current.found.features, matches_, scratch_);
    pairs_of(matches_, previous.found.features, current.found.features, pairs);
  }
  std::size_t count(const Found& found) const override { return found.features.size(); }

 private:
  MatchNearest match_nearest_{{.ratio = kRatio}};
  MatchNearest::Scratch scratch_;
  Matches matches_;
};

}  // namespace pavo::bench
