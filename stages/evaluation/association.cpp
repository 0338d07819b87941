#include "stages/evaluation/association.h"

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

namespace pavo {
namespace {

void check(const Trajectory& trajectory, const std::string& which) {
  for (std::size_t i = 0; i < trajectory.T_w_c.size(); ++i) {
    if (!trajectory.T_w_c[i].R.allFinite() || !trajectory.T_w_c[i].t.allFinite())
      throw std::runtime_error("pose " + std::to_string(i) + " of the " + which + " is not finite");
  }
  if (trajectory.t_ns.empty()) return;
  if (trajectory.t_ns.size() != trajectory.T_w_c.size())
    throw std::runtime_error("the " + which + " has " + std::to_string(trajectory.T_w_c.size()) + " poses but " +
                             std::to_string(trajectory.t_ns.size()) + " times: expected one per pose");
  if (std::adjacent_find(trajectory.t_ns.begin(), trajectory.t_ns.end(), std::greater_equal<>()) !=
      trajectory.t_ns.end())
    throw std::runtime_error("the times of the " + which + " do not increase");
  constexpr std::int64_t kLatest_ns = 4'000'000'000'000'000'000;  // differences stay within 64 bits
  if (!trajectory.t_ns.empty() && (trajectory.t_ns.front() < -kLatest_ns || trajectory.t_ns.back() > kLatest_ns))
    throw std::runtime_error("the times of the " + which + " are out of range");
}

enum class Tie { earlier, later };

std::size_t nearest(const std::vector<std::int64_t>& sorted_ns, std::int64_t t_ns, Tie tie) {
  const auto after = std::lower_bound(sorted_ns.begin(), sorted_ns.end(), t_ns);
  if (after == sorted_ns.begin()) return 0;
  const auto before = after - 1;
  const std::int64_t wait_ns = after == sorted_ns.end() ? std::numeric_limits<std::int64_t>::max() : *after - t_ns;
  const std::int64_t past_ns = t_ns - *before;
  const bool later = wait_ns < past_ns || (wait_ns == past_ns && tie == Tie::later);
  return static_cast<std::size_t>((later ? after : before) - sorted_ns.begin());
}

/// A pair is mutual: each is the other's nearest. So it is one to one, and keeps the order. Where a pose lies right in
/// the middle between two, the truth's is taken before it, and so the estimate's after it.
PosePairs associate_by_time(const Trajectory& estimate, const Trajectory& truth, std::int64_t largest_gap_ns) {
  PosePairs pairs;
  pairs.by_time = true;
  for (std::size_t i = 0; i < estimate.t_ns.size(); ++i) {
    const std::size_t j = nearest(truth.t_ns, estimate.t_ns[i], Tie::earlier);
    const std::int64_t gap_ns = std::abs(truth.t_ns[j] - estimate.t_ns[i]);
    if (gap_ns > largest_gap_ns || nearest(estimate.t_ns, truth.t_ns[j], Tie::later) != i) continue;
    pairs.estimate.push_back(estimate.T_w_c[i]);
    pairs.truth.push_back(truth.T_w_c[j]);
    pairs.largest_gap_ns = std::max(pairs.largest_gap_ns, gap_ns);
  }
  return pairs;
}

}  // namespace

PosePairs associate(const Trajectory& estimate, const Trajectory& truth, std::int64_t largest_gap_ns) {
  check(estimate, "estimate");
  check(truth, "ground truth");
  const std::string counts = "the estimate has " + std::to_string(estimate.T_w_c.size()) + " poses, the ground truth " +
                             std::to_string(truth.T_w_c.size());
  PosePairs pairs;
  if (!estimate.t_ns.empty() && !truth.t_ns.empty()) {
    pairs = associate_by_time(estimate, truth, largest_gap_ns);
  } else if (estimate.T_w_c.size() == truth.T_w_c.size()) {
    pairs.estimate = estimate.T_w_c;
    pairs.truth = truth.T_w_c;
  } else {
    throw std::runtime_error(counts + ", and not both have times: expected as many, or times in both (TUM format)");
  }
  if (pairs.estimate.size() < 2)
    throw std::runtime_error(counts + ", of which " + std::to_string(pairs.estimate.size()) +
                             (pairs.by_time ? " agree in time (at most " + std::to_string(largest_gap_ns / 1'000'000) +
                                                  " ms apart): expected two or more, with times of the same clock"
                                            : " can be compared: expected two or more"));
  return pairs;
}

double path_length_m(const std::vector<SE3>& T_w_c) {
  double length_m = 0;
  for (std::size_t i = 1; i < T_w_c.size(); ++i) length_m += (T_w_c[i].t - T_w_c[i - 1].t).norm();
  return length_m;
}

}  // namespace pavo
