#include "stages/people/symmetry.h"

#include <stdexcept>

#include "stages/people/hog.h"

namespace pavo {

std::vector<double> symmetric(std::span<const double> w) {
  using namespace hog;
  if (w.size() != kDescriptorSize + 1) throw std::invalid_argument("symmetric: expected 3780 weights and the bias");
  std::vector<double> mean(w.begin(), w.end());
  for (int by = 0; by < kBlocksY; ++by)
    for (int bx = 0; bx < kBlocksX; ++bx)
      for (int cy = 0; cy < 2; ++cy)
        for (int cx = 0; cx < 2; ++cx)
          for (int bin = 0; bin < kBins; ++bin) {
            // Bin b is centred at (20 b + 10) degrees, and the mirror image of an orientation a is 180 degrees - a.
            const std::size_t here = descriptor_index(by, bx, cy, cx, bin);
            const std::size_t there = descriptor_index(by, kBlocksX - 1 - bx, cy, 1 - cx, kBins - 1 - bin);
            mean[here] = (w[here] + w[there]) / 2;
          }
  return mean;
}

}  // namespace pavo
