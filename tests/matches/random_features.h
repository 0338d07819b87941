// Features made of random numbers, and the answer by brute force in double.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include "stages/features/features.h"
#include "stages/matches/matches.h"

namespace pavo::test {

inline void normalise(Features& features, std::size_t i) {
  float* d = features.descriptor(i);
  double norm2 = 0;
  for (int k = 0; k < Features::kDescriptorSize; ++k) norm2 += static_cast<double>(d[k]) * static_cast<double>(d[k]);
  for (int k = 0; k < Features::kDescriptorSize; ++k)
    d[k] = static_cast<float>(static_cast<double>(d[k]) / std::sqrt(norm2));
}

inline Features random_features(std::size_t n, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  Features features;
  features.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto place = static_cast<float>(random() % 1000);
    features.keypoints.push_back({place, static_cast<float>(random() % 300), 1, 0});
    for (int k = 0; k < Features::kDescriptorSize; ++k) features.descriptor(i)[k] = normal(random);
    normalise(features, i);
  }
  return features;
}

/// The same features seen again: in another order, with noise; some are replaced by others.
inline Features seen_again(const Features& features, float noise, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  Features again = random_features(features.size(), seed + 1);
  for (std::size_t i = 0; i < features.size(); ++i) {
    const std::size_t j = (i * 7 + 3) % features.size();
    if (i % 5 == 0) continue;
    again.keypoints[j] = features.keypoints[i];
    for (int k = 0; k < Features::kDescriptorSize; ++k)
      again.descriptor(j)[k] = features.descriptor(i)[k] + noise * normal(random);
    normalise(again, j);
  }
  return again;
}

struct BruteForce {
  std::vector<std::vector<double>> d2;
  BruteForce(const Features& a, const Features& b) : d2(a.size(), std::vector<double>(b.size())) {
    for (std::size_t i = 0; i < a.size(); ++i)
      for (std::size_t j = 0; j < b.size(); ++j)
        for (int k = 0; k < Features::kDescriptorSize; ++k) {
          const double d = static_cast<double>(a.descriptor(i)[k]) - static_cast<double>(b.descriptor(j)[k]);
          d2[i][j] += d * d;
        }
  }

  /// The definition in nearest.h, word by word.
  Matches mutual(double ratio, std::span<const std::uint8_t> keep_a = {},
                 std::span<const std::uint8_t> keep_b = {}) const {
    const auto kept = [](std::span<const std::uint8_t> keep, std::size_t i) { return keep.empty() || keep[i] != 0; };
    Matches matches;
    for (std::size_t i = 0; i < d2.size(); ++i) {
      if (!kept(keep_a, i)) continue;
      constexpr double kNone = std::numeric_limits<double>::infinity();
      double nearest = kNone, second = kNone;
      std::size_t j = 0;
      for (std::size_t c = 0; c < d2[i].size(); ++c) {
        if (!kept(keep_b, c)) continue;
        if (d2[i][c] < nearest)
          second = nearest, nearest = d2[i][c], j = c;
        else if (d2[i][c] < second)
          second = d2[i][c];
      }
      if (nearest == kNone) continue;
      bool mutual = true;
      for (std::size_t r = 0; r < d2.size(); ++r)
        if (kept(keep_a, r) && (d2[r][j] < nearest || (d2[r][j] == nearest && r < i))) mutual = false;
      if (mutual && (ratio >= 1 || nearest < ratio * ratio * second))
        matches.push_back({static_cast<int>(i), static_cast<int>(j), static_cast<float>(std::sqrt(nearest))});
    }
    return matches;
  }
};

inline bool same(const Match& a, const Match& b) {
  return a.previous == b.previous && a.current == b.current && a.distance == b.distance;
}

inline bool equal(const Matches& a, const Matches& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (!same(a[i], b[i])) return false;
  return true;
}

}  // namespace pavo::test
