// The parallel stage `scan`: which boxes of one image hold a person.
//
// A scan is a function object `void operator()(const Image&, Detections&, Scratch&) const` with `using Scratch`. It
// knows nothing of other frames; any number of threads may call it at once, each with a Scratch of its own.
#pragma once

#include "stages/people/scan_hog.h"

namespace pavo {

using ScanPeople = ScanPeopleHog;

}  // namespace pavo
