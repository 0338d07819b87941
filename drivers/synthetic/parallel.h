// A loop over independent pieces of work, on several threads.
#pragma once

#include <functional>

namespace pavo::synthetic {

/// Calls f(i) once for every i in [0, count), on the caller's thread and threads - 1 others (0: one per core), which
/// end before it returns. Threads of its own and not TBB's: they live for a picture, take nothing from the pools of
/// the stages that run meanwhile, and the thread sanitizer sees all of what they do. What f throws (the first of it)
/// is thrown again here, after all have ended.
void for_each_index(int count, int threads, const std::function<void(int)>& f);

}  // namespace pavo::synthetic
