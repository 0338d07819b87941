#include "stages/evaluation/evaluation.h"

#include <stdexcept>

namespace pavo {
namespace {

AlignedErrors align_and_measure(const PosePairs& pairs, Alignment alignment) {
  const Similarity similarity = align(pairs, alignment);
  return {similarity, absolute_errors_m(pairs, similarity)};
}

ScaledErrors measure(const PosePairs& pairs, double scale, const std::vector<double>& lengths_m, int step) {
  return {scale, pose_rmse(pairs, scale), motion_rmse(pairs, scale), motion_errors(pairs, scale),
          segment_errors(pairs, scale, lengths_m, step)};
}

}  // namespace

const AlignedErrors& Evaluation::aligned(Alignment alignment) const {
  switch (alignment) {
    case Alignment::none:
      return none;
    case Alignment::scale:
      return scale;
    case Alignment::se3:
      return se3;
    case Alignment::sim3:
      return sim3;
  }
  throw std::invalid_argument("no such alignment");
}

Evaluation evaluate(const Trajectory& estimate, const Trajectory& truth, const EvaluationOptions& options) {
  const PosePairs pairs = associate(estimate, truth, options.largest_gap_ns);

  Evaluation result;
  result.pairs = pairs.truth.size();
  result.estimate_poses = estimate.T_w_c.size();
  result.truth_poses = truth.T_w_c.size();
  result.by_time = pairs.by_time;
  result.truth_length_m = path_length_m(pairs.truth);
  result.estimate_length_m = path_length_m(pairs.estimate);

  result.none = align_and_measure(pairs, Alignment::none);
  result.scale = align_and_measure(pairs, Alignment::scale);
  result.se3 = align_and_measure(pairs, Alignment::se3);
  result.sim3 = align_and_measure(pairs, Alignment::sim3);

  const std::vector<double> lengths_m =
      options.lengths_m.empty() ? segment_lengths_m(result.truth_length_m) : options.lengths_m;
  result.raw = measure(pairs, 1, lengths_m, options.step);
  if (result.sim3.similarity.scale_known)
    result.scaled = measure(pairs, result.sim3.similarity.scale, lengths_m, options.step);
  return result;
}

}  // namespace pavo
