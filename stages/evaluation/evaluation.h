// An estimated path against the true one: all the figures that `pavo eval` prints, in one go.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "stages/evaluation/alignment.h"
#include "stages/evaluation/association.h"
#include "stages/evaluation/errors.h"
#include "types/pose.h"

namespace pavo {

struct EvaluationOptions {
  int step = 10;                  ///< segments start at every step-th frame, as KITTI does; >= 1
  std::vector<double> lengths_m;  ///< of the segments; empty: segment_lengths_m() of the true path
  std::int64_t largest_gap_ns = kLargestPairGap_ns;
};

struct AlignedErrors {
  Similarity similarity;  ///< from the estimate's world to the truth's
  Statistics ate_m;
};

/// What depends on the estimate's scale.
struct ScaledErrors {
  double scale = 1;  ///< what the estimate's translations were multiplied by
  ParameterRmse poses;
  ParameterRmse motions;
  MotionErrors rpe;
  SegmentErrorsByLength segments;
};

struct Evaluation {
  std::size_t pairs = 0;           ///< poses that were compared
  std::size_t estimate_poses = 0;  ///< in the estimate
  std::size_t truth_poses = 0;     ///< in the ground truth
  bool by_time = false;            ///< how they were paired
  double truth_length_m = 0;       ///< of the paired poses
  double estimate_length_m = 0;

  AlignedErrors none, scale, se3, sim3;

  ScaledErrors raw;  ///< as the estimate stands
  /// After one global scale: that of the Sim(3) alignment of all camera centres (sim3.similarity.scale). It is one
  /// number for the whole path, so that a drift of scale still counts. Nothing where a path stands still.
  std::optional<ScaledErrors> scaled;

  const AlignedErrors& aligned(Alignment alignment) const;
};

/// No figure is ever NaN or infinite. Throws as associate() does.
Evaluation evaluate(const Trajectory& estimate, const Trajectory& truth, const EvaluationOptions& options = {});

}  // namespace pavo
