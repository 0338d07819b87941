#include "stages/matches/nearest.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "stages/matches/nearest_kernel.h"

namespace pavo {
namespace {

using Scratch = MatchNearest::Scratch;
using Side = Scratch::Side;
constexpr int kSize = Features::kDescriptorSize;
static_assert(kSize == nearest_kernel::kDepth);
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr float kLargestNorm2 = 1e30f;  // what is below can be squared and added

nearest_kernel::Quantised quantised(const Side& side) {
  return {side.quantised.data.get(), side.half_norm.data.get(), side.rows.size()};
}

/// Collects the descriptors that take part. Returns the largest |d|^2.
float gather(const Features& features, std::span<const std::uint8_t> keep, const char* name, Side& side) {
  const std::size_t n = features.size();
  if (!keep.empty() && keep.size() != n)
    throw std::invalid_argument("matching: keep_" + std::string(name) + " has " + std::to_string(keep.size()) +
                                " flags for " + std::to_string(n) +
                                " keypoints; expected one for each, or none at all");
  side.index.clear();
  side.rows.clear();
  side.index.reserve(n);
  side.rows.reserve(n);
  float largest = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (!keep.empty() && keep[i] == 0) continue;
    const float norm2 = nearest_kernel::norm2(features.descriptor(i));
    if (!(norm2 < kLargestNorm2)) continue;  // nor what is no number
    largest = std::max(largest, norm2);
    side.index.push_back(static_cast<int>(i));
    side.rows.push_back(features.descriptor(i));
  }
  return largest;
}

void quantise(float scale, Side& side) {
  const std::size_t n = side.rows.size();
  side.quantised.reserve(n * kSize);
  side.half_norm.reserve(n);
  float largest = 0;
  for (std::size_t i = 0; i < n; ++i)
    largest = std::max(largest, nearest_kernel::quantise(side.rows[i], scale, side.quantised.data.get() + i * kSize,
                                                         side.half_norm.data.get() + i));
  side.largest_error = std::sqrt(static_cast<double>(largest));
}

/// The distance that counts: the sum of squares in double, k ascending. Sums only grow: beyond `limit` it may stop
/// early.
double squared_distance(const float* a, const float* b, double limit = kInfinity) {
  double sum = 0;
  for (int k = 0; k < kSize; k += 16) {
    for (int l = k; l < k + 16; ++l) {
      const double d = static_cast<double>(a[l]) - static_cast<double>(b[l]);
      sum += d * d;
    }
    if (sum > limit) break;
  }
  return sum;
}

struct Nearest {
  int index = -1;
  double d2 = kInfinity;
  double second_d2 = kInfinity;
};

/// By brute force in double, among the candidates.
Nearest decide(const float* descriptor, const Side& others, std::span<const std::int32_t> candidates) {
  Nearest nearest;
  for (const std::int32_t j : candidates) {
    const double d2 = squared_distance(descriptor, others.rows[static_cast<std::size_t>(j)], nearest.second_d2);
    if (d2 < nearest.d2) {
      nearest.second_d2 = nearest.d2;
      nearest.d2 = d2;
      nearest.index = j;
    } else {
      nearest.second_d2 = std::min(nearest.second_d2, d2);
    }
  }
  return nearest;
}

/// What the integer kernel knows, and how well. With q_a = s a + e_a, the distances obey | |q_a - q_b| - s |a - b| | <=
/// |e_a| + |e_b|, and the largest |e| of either side is known.
class Decisions {
 public:
  Decisions(const MatchNearest::Options& options, float scale, std::size_t lanes, Scratch& scratch)
      : previous_(scratch.previous),
        current_(scratch.current),
        near_(scratch.near),
        scale_(static_cast<double>(scale)),
        // 2 is for the half norms (a score may be 1 too small: sqrt(2) at most) and for the rounding of s a in float
        error_(scratch.previous.largest_error + scratch.current.largest_error + 2),
        ratio_(static_cast<double>(options.ratio)),
        lanes_(static_cast<int>(lanes)) {}

  /// The mutual nearest of the previous descriptor i that passes the ratio test; index -1: there is none.
  Nearest mutual(std::size_t i) {
    const double first = distance(previous_.score, i), second = distance(previous_.second, i);
    if (second - first <= 2 * error_) {
      const Nearest nearest = decide_row(i);
      return is_mutual(i, nearest) && (ratio_ >= 1 || nearest.d2 < ratio_ * ratio_ * nearest.second_d2) ? nearest
                                                                                                        : Nearest();
    }
    const Nearest nearest = candidate(i, first);
    return nearest.index >= 0 && is_mutual(i, nearest) && passes_ratio(i, nearest, second) ? nearest : Nearest();
  }

 private:
  using Array = Scratch::Array<std::int32_t>;

  /// In quantised units.
  static double distance(const Array& scores, std::size_t i) {
    const std::int32_t score = scores.data[i];
    return score < nearest_kernel::kNone ? kInfinity : std::sqrt(-2.0 * std::min(score, 0));
  }
  double square_of(double quantised_distance) const {
    const double d = std::max(0.0, quantised_distance) / scale_;
    return d * d;
  }

  /// Among the columns where the nearest of row i is; it is not open which one. Only if i may be its nearest, too.
  Nearest candidate(std::size_t i, double first) const {
    const double limit = square_of(first + error_);
    int j = previous_.nearest.data[i];
    for (std::size_t v = 0; v < nearest_kernel::kVectors; ++v, j += lanes_) {
      const auto column = static_cast<std::size_t>(j);
      if (column >= current_.rows.size()) break;
      if (current_.score.data[column] < previous_.score.data[i]) continue;  // then it is not row i's best
      if (distance(current_.score, column) + 2 * error_ < first) continue;  // it has a nearer one for sure
      const double d2 = squared_distance(previous_.rows[i], current_.rows[column], limit);
      if (d2 <= limit) return {j, d2, kInfinity};
    }
    return {};
  }

  bool is_mutual(std::size_t i, const Nearest& nearest) {
    const auto j = static_cast<std::size_t>(nearest.index);
    const double first = distance(current_.score, j), second = distance(current_.second, j);
    if (second - first > 2 * error_) return nearest.d2 <= square_of(first + error_);
    std::int32_t& decided = current_.nearest.data[j];
    if (decided < 0) decided = decide(current_.rows[j], previous_, near(current_, j, first, previous_)).index;
    return decided == static_cast<std::int32_t>(i);
  }

  bool passes_ratio(std::size_t i, const Nearest& nearest, double second) {
    if (ratio_ >= 1) return true;
    if (nearest.d2 < ratio_ * ratio_ * square_of(second - error_)) return true;
    if (nearest.d2 > ratio_ * ratio_ * square_of(second + error_)) return false;
    return nearest.d2 < ratio_ * ratio_ * decide_row(i).second_d2;
  }

  Nearest decide_row(std::size_t i) {
    return decide(previous_.rows[i], current_, near(previous_, i, distance(previous_.second, i), current_));
  }

  /// All that can be as near as what is seen at `seen`.
  std::span<const std::int32_t> near(const Side& side, std::size_t of, double seen, const Side& others) {
    near_.reserve(others.rows.size());
    const double farthest = std::min(seen + 2 * error_, 1e6);  // farther than any
    const auto threshold = static_cast<std::int64_t>(-farthest * farthest / 2) - 2;
    const std::size_t n =
        nearest_kernel::find_near(quantised(side), of, quantised(others), threshold, near_.data.get());
    return {near_.data.get(), n};
  }

  Side& previous_;
  Side& current_;
  Array& near_;
  double scale_;
  double error_;
  double ratio_;
  int lanes_;
};

std::size_t run_kernel(Spread* spread, Scratch& s) {
  constexpr std::size_t kBand = 256;  // rows that one helper takes at a time
  const std::size_t rows = s.previous.rows.size(), columns = nearest_kernel::padded(s.current.rows.size());
  const std::size_t bands = (rows + kBand - 1) / kBand;
  for (auto* array : {&s.previous.score, &s.previous.second, &s.previous.nearest}) array->reserve(rows);
  for (auto* array : {&s.lane_score, &s.lane_second, &s.lane_column}) array->reserve(rows * nearest_kernel::kLanes);
  for (auto* array : {&s.current.score, &s.current.second, &s.current.nearest, &s.panel_half_norm})
    array->reserve(columns);
  for (auto* array : {&s.band_score, &s.band_second}) array->reserve(bands * columns);
  s.panels.reserve(columns * kSize / 2);
  s.near.reserve(std::max(rows, columns));
  std::fill_n(s.current.nearest.data.get(), columns, -1);

  const nearest_kernel::Packed packed{s.panels.data.get(), s.panel_half_norm.data.get()};
  const std::size_t lanes = nearest_kernel::pack(quantised(s.current), packed);
  const auto of_band = [&](std::size_t band) -> nearest_kernel::BestTwo {
    if (band == 0) return {s.current.score.data.get(), s.current.second.data.get()};
    return {s.band_score.data.get() + band * columns, s.band_second.data.get() + band * columns};
  };
  const auto turn = [&](int, int k) {
    const std::size_t band = static_cast<std::size_t>(k), first = band * kBand;
    const std::size_t at = first * nearest_kernel::kLanes;
    nearest_kernel::best_two_both_ways(
        {s.previous.quantised.data.get() + first * kSize, s.previous.half_norm.data.get() + first,
         std::min(kBand, rows - first)},
        packed, s.current.rows.size(),
        {{s.lane_score.data.get() + at, s.lane_second.data.get() + at}, s.lane_column.data.get() + at},
        {{s.previous.score.data.get() + first, s.previous.second.data.get() + first},
         s.previous.nearest.data.get() + first},
        of_band(band));
  };
  spread_or_not(spread, static_cast<int>(bands), turn);
  for (std::size_t band = 1; band < bands; ++band)
    nearest_kernel::merge(of_band(band), s.current.rows.size(), of_band(0));
  return lanes;
}

bool moved_too_far(const Keypoint& a, const Keypoint& b, float limit) {
  const float dx = b.x - a.x, dy = b.y - a.y;
  return limit > 0 && dx * dx + dy * dy > limit * limit;
}

}  // namespace

MatchNearest::MatchNearest(const Options& options) : options_(options) {
  if (!(options.ratio > 0))
    throw std::invalid_argument("matching: ratio must be above 0, is " + std::to_string(options.ratio));
  if (!(options.max_displacement_px >= 0))
    throw std::invalid_argument("matching: max_displacement_px must be 0 (off) or more, is " +
                                std::to_string(options.max_displacement_px));
}

void MatchNearest::operator()(const Features& previous, const Features& current,
                              std::span<const std::uint8_t> keep_previous, std::span<const std::uint8_t> keep_current,
                              Matches& out, Scratch& scratch) const {
  out.clear();
  const float largest = std::max(gather(previous, keep_previous, "previous", scratch.previous),
                                 gather(current, keep_current, "current", scratch.current));
  const std::size_t rows = scratch.previous.rows.size(), columns = scratch.current.rows.size();
  if (rows == 0 || columns == 0) return;
  const float scale = largest > 1e-30f ? nearest_kernel::kLargestNorm / std::sqrt(largest) : 1.0f;
  quantise(scale, scratch.previous);
  quantise(scale, scratch.current);
  const std::size_t lanes = run_kernel(options_.spread, scratch);

  out.reserve(std::min(rows, columns));
  Decisions decisions(options_, scale, lanes, scratch);
  for (std::size_t i = 0; i < rows; ++i) {
    const Nearest nearest = decisions.mutual(i);
    if (nearest.index < 0) continue;
    const int p = scratch.previous.index[i], c = scratch.current.index[static_cast<std::size_t>(nearest.index)];
    const Keypoint& from = previous.keypoints[static_cast<std::size_t>(p)];
    const Keypoint& to = current.keypoints[static_cast<std::size_t>(c)];
    if (moved_too_far(from, to, options_.max_displacement_px)) continue;
    out.push_back({p, c, static_cast<float>(std::sqrt(nearest.d2))});
  }
}

void pairs_of(const Matches& matches, const Features& previous, const Features& current, PointPairs& out) {
  out.clear();
  out.reserve(matches.size());
  for (const Match& match : matches) {
    const Keypoint& from = previous.keypoints[static_cast<std::size_t>(match.previous)];
    const Keypoint& to = current.keypoints[static_cast<std::size_t>(match.current)];
    out.push_back({from.x, from.y, to.x, to.y});
  }
}

}  // namespace pavo
