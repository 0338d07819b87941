// tbb::parallel_pipeline. Its first filter sleeps until a frame arrives, and keeps a thread while it does: three
// threads are tried beside two. "Nested": the turns inside a stage are a tbb::parallel_for.
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include "bench/pipeline/competitors.h"
#include "stages/people/arena_spread.h"

namespace pavo::bench {
namespace {

void run(Work& work, Feed& feed, const Setup& setup, bool nested) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(setup.threads));
  tbb::task_arena arena(setup.threads);
  ArenaSpread spread(arena);
  work.begin(setup.tokens, nested ? &spread : nullptr);
  const auto stage = [&](int s) {
    return [&work, s](std::int64_t k) {
      work.stage(s, k);
      return k;
    };
  };
  using tbb::filter_mode;
  using Filter = tbb::filter<std::int64_t, std::int64_t>;
  arena.execute([&] {
    tbb::parallel_pipeline(static_cast<std::size_t>(setup.tokens),
                           tbb::make_filter<void, std::int64_t>(filter_mode::serial_in_order,
                                                                [&](tbb::flow_control& control) -> std::int64_t {
                                                                  const std::int64_t k = feed.next();
                                                                  if (k < 0)
                                                                    control.stop();
                                                                  else
                                                                    work.load(k);
                                                                  return k;
                                                                }) &
                               Filter(filter_mode::parallel, stage(0)) & Filter(filter_mode::parallel, stage(1)) &
                               Filter(filter_mode::parallel, stage(2)) &
                               Filter(filter_mode::serial_in_order, stage(3)) &
                               tbb::make_filter<std::int64_t, void>(filter_mode::serial_in_order, [&](std::int64_t k) {
                                 work.stage(4, k);
                                 feed.done(k);
                               }));
  });
}

}  // namespace

void run_tbb_pipeline(Work& work, Feed& feed, const Setup& setup) {
  run(work, feed, setup, false);
}

void run_tbb_pipeline_nested(Work& work, Feed& feed, const Setup& setup) {
  run(work, feed, setup, true);
}

}  // namespace pavo::bench
