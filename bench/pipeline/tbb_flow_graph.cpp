// tbb::flow::graph with the true dependencies: features and scan at the same time, joined by the frame's number.
#include <oneapi/tbb/flow_graph.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <semaphore>
#include <tuple>

#include "bench/pipeline/competitors.h"

namespace pavo::bench {

void run_tbb_flow_graph(Work& work, Feed& feed, const Setup& setup) {
  using namespace tbb::flow;
  using Number = std::int64_t;
  using Both = std::tuple<Number, Number>;
  // The thread that waits for frames is one more, and takes no part.
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(setup.threads) + 1);
  tbb::task_arena arena(setup.threads + 1, 1);  // the one is the caller's place
  work.begin(setup.tokens, nullptr);
  std::counting_semaphore<64> tokens(setup.tokens);
  arena.execute([&] {
    graph g;
    const auto stage = [&work](int s) {
      return [&work, s](Number k) {
        work.stage(s, k);
        return k;
      };
    };
    const auto number = [](Number k) { return static_cast<std::size_t>(k); };
    function_node<Number, Number> decode(g, unlimited, stage(0)), features(g, unlimited, stage(1)),
        scan(g, unlimited, stage(2)), people(g, serial, stage(3));
    sequencer_node<Number> scanned(g, number);
    join_node<Both, key_matching<Number>> both(
        g, [](Number k) { return k; }, [](Number k) { return k; });
    sequencer_node<Both> joined(g, [](const Both& b) { return static_cast<std::size_t>(std::get<0>(b)); });
    function_node<Both, continue_msg> odometry(g, serial, [&](const Both& b) {
      work.stage(4, std::get<0>(b));
      feed.done(std::get<0>(b));
      tokens.release();
      return continue_msg();
    });
    make_edge(decode, features);
    make_edge(decode, scan);
    make_edge(scan, scanned);
    make_edge(scanned, people);
    make_edge(features, input_port<0>(both));
    make_edge(people, input_port<1>(both));
    make_edge(both, joined);
    make_edge(joined, odometry);
    for (;;) {
      tokens.acquire();
      const Number k = feed.next();
      if (k < 0) break;
      work.load(k);
      decode.try_put(k);
    }
    g.wait_for_all();
  });
}

}  // namespace pavo::bench
