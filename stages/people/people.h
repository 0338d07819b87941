// People in the picture.
#pragma once

#include <vector>

namespace pavo {

/// The box of a person (not of the detector's window), pixels of the rectified image; may reach beyond its edges.
struct PersonBox {
  float x = 0, y = 0, width = 0, height = 0;
  float score = 0;
};
using Detections = std::vector<PersonBox>;  ///< what the scan of one frame saw
using People = std::vector<PersonBox>;      ///< who is there, after tracking over time

}  // namespace pavo
