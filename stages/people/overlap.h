// How much two boxes share.
#pragma once

#include <algorithm>

#include "stages/people/people.h"

namespace pavo {

inline float area(const PersonBox& a) {
  return a.width * a.height;
}

inline float intersection(const PersonBox& a, const PersonBox& b) {
  const float w = std::min(a.x + a.width, b.x + b.width) - std::max(a.x, b.x);
  const float h = std::min(a.y + a.height, b.y + b.height) - std::max(a.y, b.y);
  return w > 0 && h > 0 ? w * h : 0.0f;
}

/// Intersection over union, 0 to 1; 0 for boxes without area.
inline float intersection_over_union(const PersonBox& a, const PersonBox& b) {
  const float shared = intersection(a, b);
  return shared > 0 ? shared / (area(a) + area(b) - shared) : 0.0f;
}

/// Intersection over the smaller box, 0 to 1: a box inside another one has 1. 0 for boxes without area.
inline float intersection_over_smaller(const PersonBox& a, const PersonBox& b) {
  const float shared = intersection(a, b);
  return shared > 0 ? shared / std::min(area(a), area(b)) : 0.0f;
}

}  // namespace pavo
