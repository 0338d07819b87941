// What all competitors run: the same five stages on the same frames.
//
//   0 decode -> 1 features ---------------> 4 odometry        0, 1, 2: any number of frames at once, in any order
//            \> 2 scan -> 3 people -------/                   3, 4: one frame at a time, in order
#pragma once

#include <cstdint>
#include <memory>

#include "drivers/sequences/sequence.h"
#include "types/spread.h"

namespace pavo::bench {

class Work {
 public:
  static constexpr int kStages = 5;
  virtual ~Work() = default;

  /// Everything new. Frame k lives in place k % (tokens + 1), so that frame k-1 is there while stage 4 has k.
  /// `spread`: who may help inside a stage; null: nobody.
  virtual void begin(int tokens, Spread* spread) = 0;
  /// Frame k into its place; by one thread at a time.
  virtual void load(std::int64_t k) = 0;
  virtual void stage(int stage, std::int64_t k) = 0;
  /// Of everything that came out of stage 4, in the order in which it did.
  virtual std::uint64_t result() const = 0;
};

/// Stages 0, 1, 2, 3, 4 use `stage_us` of CPU time each; 0: nothing at all.
std::unique_ptr<Work> synthetic_work(double stage_us);

/// pavo's own stages, the frames in memory as the source delivers them. Throws std::runtime_error.
std::unique_ptr<Work> real_work(Sequence& sequence, int frames);

}  // namespace pavo::bench
