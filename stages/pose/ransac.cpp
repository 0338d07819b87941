#include "stages/pose/ransac.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace pavo {
namespace {

constexpr int kLocalSteps = 4;

// Eight different indices below n. Redrawing a double one keeps the others' distribution uniform.
void draw_sample(Random& random, std::uint32_t n, std::array<std::uint32_t, 8>& sample) {
  for (std::size_t i = 0; i < sample.size();) {
    sample[i] = random.below(n);
    if (std::find(sample.begin(), sample.begin() + i, sample[i]) == sample.begin() + i) ++i;
  }
}

int iterations_needed(double inlier_share, double confidence, int most) {
  const double clean = std::pow(inlier_share, 8);  // the probability of a sample without outliers
  if (clean >= confidence) return 1;
  const double needed = std::log1p(-confidence) / std::log1p(-clean);
  return needed < most ? static_cast<int>(std::ceil(needed)) : most;
}

class Search {
 public:
  Search(std::span<const PointPair> pairs, const RansacOptions& options, std::vector<std::uint8_t>& is_inlier,
         RansacScratch& scratch)
      : pairs_(pairs),
        options_(options),
        threshold_(static_cast<float>(options.threshold_px)),
        is_inlier_(is_inlier),
        scratch_(scratch),
        by_(normalisation_of(pairs)) {
    scratch_.points.assign(pairs);
    scratch_.normalised.clear();
    for (const PointPair& pair : pairs) scratch_.normalised.push_back(normalised(pair, by_));
  }

  // Takes F (between normalised points, of rank 2) for the best where it is.
  bool try_model(const Eigen::Matrix3d& F) {
    const Eigen::Matrix3d F_pixels = denormalised(F, by_);
    const SampsonModel model = sampson_model(F_pixels, scratch_.points);
    const float cost = sampson_cost(scratch_.points, model, threshold_, best_cost_);
    if (!(cost < best_cost_)) return false;
    best_cost_ = cost;
    best_ = F_pixels;
    best_model_ = model;
    history_[history_size_++ % RansacResult::kCandidates] = F_pixels;
    return true;
  }

  // One over the squared gradient of x'^T F x by the four coordinates: makes the algebraic error Sampson's (Luong and
  // Faugeras, IJCV 1996).
  double gradient_weight(const PointPair& pair) const {
    const Eigen::Vector3d p(pair.x_previous, pair.y_previous, 1), c(pair.x_current, pair.y_current, 1);
    const double slope = (best_.topRows<2>() * p).squaredNorm() + (best_.leftCols<2>().transpose() * c).squaredNorm();
    return 1 / std::max(slope, std::numeric_limits<double>::min());
  }

  // Reweighted least squares over the best model's inliers, as long as that makes it better.
  void improve() {
    for (int step = 0; step < kLocalSteps; ++step) {
      if (mark_inliers() < 12) return;
      EightPointSystem system;
      for (std::size_t i = 0; i < pairs_.size(); ++i)
        if (is_inlier_[i]) system.add(scratch_.normalised[i], gradient_weight(pairs_[i]));
      if (!try_model(nearest_rank2(system.solve()))) return;
    }
  }

  int mark_inliers() { return sampson_inliers(scratch_.points, best_model_, threshold_, is_inlier_); }
  double share(int inliers) const { return static_cast<double>(inliers) / static_cast<double>(pairs_.size()); }
  const Eigen::Matrix3d& best() const { return best_; }

  void copy_candidates(RansacResult& result) const {
    result.candidate_count = std::min(history_size_, RansacResult::kCandidates);
    for (std::size_t i = 0; i < result.candidate_count; ++i)
      result.candidates[i] = history_[(history_size_ - 1 - i) % RansacResult::kCandidates];
  }

  int run(Random& random) {
    int needed = options_.max_iterations, drawn = 0;
    std::array<std::uint32_t, 8> sample;
    std::array<NormalisedPair, 8> eight;
    for (; drawn < std::max(needed, options_.min_iterations); ++drawn) {
      draw_sample(random, static_cast<std::uint32_t>(pairs_.size()), sample);
      for (std::size_t i = 0; i < 8; ++i) eight[i] = scratch_.normalised[sample[i]];
      Eigen::Matrix3d F;
      if (!eight_point_minimal(eight, F) || !try_model(rank2_by_iteration(F))) continue;
      improve();
      needed = std::min(needed, iterations_needed(share(mark_inliers()), options_.confidence, options_.max_iterations));
    }
    return drawn;
  }

 private:
  std::span<const PointPair> pairs_;
  const RansacOptions& options_;
  float threshold_;
  std::vector<std::uint8_t>& is_inlier_;
  RansacScratch& scratch_;
  PairNormalisation by_;
  float best_cost_ = std::numeric_limits<float>::infinity();
  Eigen::Matrix3d best_ = Eigen::Matrix3d::Zero();
  SampsonModel best_model_{};
  std::array<Eigen::Matrix3d, RansacResult::kCandidates> history_;  // of best_, a ring
  std::size_t history_size_ = 0;
};

}  // namespace

RansacResult ransac_fundamental(std::span<const PointPair> pairs, const RansacOptions& options, Random random,
                                std::vector<std::uint8_t>& is_inlier, RansacScratch& scratch) {
  is_inlier.assign(pairs.size(), 0);
  RansacResult result;
  if (pairs.size() < 8) return result;
  Search search(pairs, options, is_inlier, scratch);
  result.iterations = search.run(random);
  if (!search.best().isZero(0)) {
    result.F = search.best();
    search.copy_candidates(result);
    result.inliers = search.mark_inliers();
    result.found = result.inliers >= options.min_inliers && search.best().allFinite();
  }
  if (!result.found) {
    std::fill(is_inlier.begin(), is_inlier.end(), std::uint8_t{0});
    result.inliers = 0;
  }
  return result;
}

}  // namespace pavo
