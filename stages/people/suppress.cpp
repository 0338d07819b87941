#include "stages/people/suppress.h"

#include <algorithm>
#include <tuple>

#include "stages/people/overlap.h"

namespace pavo {

void suppress_non_maxima(Detections& boxes, float largest_share) {
  std::sort(boxes.begin(), boxes.end(), [](const PersonBox& a, const PersonBox& b) {
    return std::tuple(-a.score, a.y, a.x, a.height, a.width) < std::tuple(-b.score, b.y, b.x, b.height, b.width);
  });
  auto kept = boxes.begin();
  for (const PersonBox box : boxes) {
    const bool covered = std::any_of(boxes.begin(), kept, [&](const PersonBox& better) {
      return intersection_over_smaller(better, box) > largest_share;
    });
    if (!covered) *kept++ = box;
  }
  boxes.erase(kept, boxes.end());
}

}  // namespace pavo
