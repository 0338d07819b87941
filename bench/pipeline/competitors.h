// Ways to bring frames through the stages with two cores.
#pragma once

#include <vector>

#include "bench/pipeline/feed.h"
#include "bench/pipeline/work.h"

namespace pavo::bench {

struct Setup {
  int tokens = 4;   ///< frames in flight
  int threads = 2;  ///< that run stages
};

struct Competitor {
  const char* name;
  void (*run)(Work&, Feed&, const Setup&);
  int least_tokens, most_tokens;
  std::vector<int> threads;  ///< to try
};

void run_plain_loop(Work&, Feed&, const Setup&);
void run_tbb_pipeline(Work&, Feed&, const Setup&);
void run_tbb_pipeline_nested(Work&, Feed&, const Setup&);
void run_tbb_flow_graph(Work&, Feed&, const Setup&);
void run_thread_per_stage(Work&, Feed&, const Setup&);
void run_pavo(Work&, Feed&, const Setup&);

}  // namespace pavo::bench
