#include "bench/matching/competitors.h"

namespace pavo::bench {

void match_pavo(Problem& problem, Pairs& pairs) {
  static const MatchNearest match(MatchNearest::Options{1, 0});  // no ratio test: OpenCV's has none with crossCheck
  match(problem.previous, problem.current, problem.matches, problem.scratch);
  pairs.clear();
  for (const Match& m : problem.matches) pairs.emplace_back(m.previous, m.current);
}

}  // namespace pavo::bench
