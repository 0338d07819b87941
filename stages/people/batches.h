// Pictures worked at by several threads, and their results taken in order.
#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include "stages/people/parallel_for.h"

namespace pavo {

/// for_each(i) -> result on the arena's threads, then take(i, result) in order on this one; false when told to stop.
template <typename Result, typename ForEach, typename Take>
bool in_batches(int n, tbb::task_arena& arena, const std::function<bool(int)>& progress, ForEach for_each, Take take) {
  constexpr int kBatch = 32;  // pictures at work at once: bounds the memory
  std::vector<Result> results(kBatch);
  for (int begin = 0; begin < n; begin += kBatch) {
    if (!progress(begin)) return false;
    const int end = std::min(begin + kBatch, n);
    parallel_for(arena, end - begin, [&](int i) { results[static_cast<std::size_t>(i)] = for_each(begin + i); });
    for (int i = begin; i < end; ++i) take(i, results[static_cast<std::size_t>(i - begin)]);
  }
  return progress(n);
}

}  // namespace pavo
