// The page of pictures of `pavo bench --plot`.
#pragma once

#include <string>

#include "tools/pavo/bench_result.h"

namespace pavo {

/// An SVG: the distribution of the age of data at every load, on an axis that gives every further nine of the
/// percentile the same room (as HdrHistogram's plots do), and the age over time.
std::string bench_svg(const BenchResult& result);

}  // namespace pavo
