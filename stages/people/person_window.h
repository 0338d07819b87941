// How the detector's window and the box of the person in it belong together.
#pragma once

#include "stages/people/people.h"

namespace pavo {

/// INRIA's windows of 64x128 hold a person about 97 px high in the middle, and the mean aspect of a person's box is
/// 0.41 (Dollar et al., Pedestrian Detection: An Evaluation of the State of the Art, PAMI 2012).
inline constexpr float kPersonShareOfWindow = 0.76f;
inline constexpr float kPersonAspect = 0.41f;

/// The person's box in a window whose top left corner is (x, y); all in pixels of the image.
inline PersonBox person_in_window(float x, float y, float width, float height, float score) {
  const float h = kPersonShareOfWindow * height;
  const float w = kPersonAspect * h;
  return {x + (width - w) / 2, y + (height - h) / 2, w, h, score};
}

}  // namespace pavo
