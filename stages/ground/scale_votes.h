// Where a start is sought: how well every scale explains what was seen, summed over the frames of the start.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace pavo {

/// A histogram over ln(metres per unit). One look rarely tells in a crowd; wrong peaks come and go, the right one
/// stays.
class ScaleVotes {
 public:
  static constexpr double kStep = 0.11;
  static constexpr int kBins = 256, kMiddle = kBins / 2;  // from e^-14 to e^14 metres per unit; 1 in the middle

  struct Peak {
    int bin = 0;
    double votes = 0;
    double second = 0;  ///< the best of those more than kApart bins away
    int width = 0;      ///< bins that have more than 0.6 of its votes
  };

  static double scale_of(int bin) { return std::exp(kStep * (bin - kMiddle)); }
  static int bin_of(double scale) {
    return std::clamp(static_cast<int>(std::lround(std::log(scale) / kStep)) + kMiddle, 0, kBins - 1);
  }

  void clear() { votes_.fill(0); }
  /// What is old counts less: the unit may have been a guess (a speed that changes).
  void fade(double factor) {
    for (double& v : votes_) v *= factor;
  }
  void add(int bin, double votes) { votes_[static_cast<std::size_t>(bin)] += votes; }

  Peak peak() const {
    constexpr int kApart = 6;
    Peak p;
    for (int i = 0; i < kBins; ++i)
      if (at(i) > p.votes) p.votes = at(i), p.bin = i;
    for (const double v : votes_) p.width += v > 0.6 * p.votes;
    // A wrong pitch goes with a wrong scale: the peak is broad, and its middle is the better guess.
    const int top = p.bin;
    double sum = 0, weights = 0;
    for (int i = std::max(0, top - kApart); i <= std::min(kBins - 1, top + kApart); ++i)
      if (at(i) > 0.9 * p.votes) sum += i, weights += 1;
    p.bin = weights > 0 ? static_cast<int>(std::lround(sum / weights)) : top;
    for (int i = 0; i < kBins; ++i)
      if (std::abs(i - p.bin) > kApart) p.second = std::max(p.second, at(i));
    return p;
  }

  double at(int bin) const { return votes_[static_cast<std::size_t>(bin)]; }

 private:
  std::array<double, kBins> votes_{};
};

}  // namespace pavo
