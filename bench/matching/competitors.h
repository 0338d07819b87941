#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "stages/features/features.h"
#include "stages/matches/nearest.h"

namespace pavo::bench {

using Pairs = std::vector<std::pair<int, int>>;  // previous, current; ascending

struct Problem {
  const Features& previous;
  const Features& current;
  MatchNearest::Scratch scratch;
  Matches matches;
};

struct Frames {
  Features previous, current;
};
std::optional<Frames> real_frames();

void match_pavo(Problem& problem, Pairs& pairs);
void match_opencv(Problem& problem, Pairs& pairs);

}  // namespace pavo::bench
