#include "bench/ransac/competitors.h"

namespace pavo::bench {

void ransac_pavo(Problem& problem, Solution& solution) {
  const RansacOptions options{.threshold_px = kThresholdPx, .confidence = kConfidence};
  const RansacResult result =
      ransac_fundamental(problem.pairs, options, Random(problem.seed), solution.is_inlier, problem.scratch);
  solution.F = result.F;
  solution.iterations = result.iterations;
}

}  // namespace pavo::bench
