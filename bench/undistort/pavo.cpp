#include "bench/undistort/competitors.h"

namespace pavo::bench {

void remap_pavo(Problem& problem) {
  problem.undistort(problem.raw, problem.image);
}

}  // namespace pavo::bench
