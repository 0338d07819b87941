// Figures of what a histogram was given since one last looked.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/histogram.h"

namespace pavo {

/// One looker; the histogram may be written to meanwhile. Allocates at the first look only.
class HistogramInterval {
 public:
  explicit HistogramInterval(const Histogram& histogram) : histogram_(&histogram) {}

  /// Since the last call, or since the beginning. The maximum, too, is a bucket's, at most 1/128 off.
  Quantiles look_ms();

 private:
  const Histogram* histogram_;
  std::vector<std::uint64_t> before_, since_;
};

}  // namespace pavo
