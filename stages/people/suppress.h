// Non-maximum suppression: of the many windows that answer to one person, the best.
#pragma once

#include "stages/people/people.h"

namespace pavo {

/// Sorts `boxes` by descending score (equal scores: by y, x, height, width, so that the result does not depend on the
/// order in which they were found) and drops each box that shares more than `largest_share` of the smaller one's area
/// with a better box that stayed. In place; allocates nothing. Quadratic in what stays.
void suppress_non_maxima(Detections& boxes, float largest_share);

}  // namespace pavo
