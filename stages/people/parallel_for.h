// A loop whose turns may run at the same time.
#pragma once

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

namespace pavo {

/// f(i) for i in [0, n), by the arena's threads, of which the caller is one. What is thrown is thrown here. Under the
/// thread sanitizer, which cannot see how TBB hands work over, the caller makes all turns.
template <typename F>
void parallel_for(tbb::task_arena& arena, int n, const F& f) {
#if defined(__SANITIZE_THREAD__)
  static_cast<void>(arena);
  for (int i = 0; i < n; ++i) f(i);
#else
  arena.execute([&] { tbb::parallel_for(0, n, f, tbb::simple_partitioner()); });
#endif
}

}  // namespace pavo
