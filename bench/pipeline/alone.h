// How long does a frame take that has the machine for itself, and how long would it take at least?
#pragma once

#include "bench/pipeline/work.h"

namespace pavo::bench {

/// A table in Markdown: the latency of frames that come one at a time, the competitors in turn, and the bound that two
/// cores have: what must be done one after the other, and half of what may be spread.
void measure_alone(Work& work, int rounds);

}  // namespace pavo::bench
