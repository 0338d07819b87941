// One thread, one frame after the other.
#include "bench/pipeline/competitors.h"

namespace pavo::bench {

void run_plain_loop(Work& work, Feed& feed, const Setup&) {
  work.begin(1, nullptr);
  for (std::int64_t k; (k = feed.next()) >= 0;) {
    work.load(k);
    for (int stage = 0; stage < Work::kStages; ++stage) work.stage(stage, k);
    feed.done(k);
  }
}

}  // namespace pavo::bench
