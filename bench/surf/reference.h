// The reference descriptors: OpenCV contrib's SURF of 300 keypoints of a KITTI frame, from the data folder.
#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numeric>
#include <vector>

#include "stages/features/features.h"

namespace pavo::bench {

struct Reference {
  std::vector<Keypoint> keypoints;
  std::vector<std::array<float, 64>> descriptors;
};

/// Lines of `x y size angle d0 ... d63`. Empty where there is no such file.
inline Reference read_reference(const std::filesystem::path& path) {
  Reference reference;
  std::ifstream file(path);
  Keypoint keypoint;
  float size, angle;
  while (file >> keypoint.x >> keypoint.y >> size >> angle) {
    std::array<float, 64> descriptor;
    for (float& value : descriptor) file >> value;
    reference.keypoints.push_back(keypoint);
    reference.descriptors.push_back(descriptor);
  }
  return reference;
}

inline double dot(const float* a, const float* b) {
  return std::inner_product(a, a + 64, b, 0.0);
}

/// Of descriptor i < n / 2, which one of the other half is nearest.
template <class Descriptor>
std::vector<std::size_t> nearest_in_other_half(std::size_t n, Descriptor descriptor) {
  std::vector<std::size_t> nearest;
  for (std::size_t i = 0; i < n / 2; ++i) {
    std::size_t best = n / 2;
    for (std::size_t j = n / 2; j < n; ++j) {
      if (dot(descriptor(i), descriptor(j)) > dot(descriptor(i), descriptor(best))) best = j;
    }
    nearest.push_back(best);
  }
  return nearest;
}

struct Agreement {
  std::vector<double> cosines;  ///< ascending
  double same_nearest = 0;      ///< the share of keypoints of the first half that keep their nearest one of the second
};

inline Agreement agreement(const Reference& reference, const Features& ours) {
  Agreement result;
  const std::size_t n = reference.keypoints.size();
  for (std::size_t i = 0; i < n; ++i)
    result.cosines.push_back(dot(reference.descriptors[i].data(), ours.descriptor(i)));
  std::sort(result.cosines.begin(), result.cosines.end());
  const auto theirs = nearest_in_other_half(n, [&](std::size_t i) { return reference.descriptors[i].data(); });
  const auto mine = nearest_in_other_half(n, [&](std::size_t i) { return ours.descriptor(i); });
  std::size_t same = 0;
  for (std::size_t i = 0; i < theirs.size(); ++i) same += theirs[i] == mine[i];
  result.same_nearest = static_cast<double>(same) / static_cast<double>(theirs.size());
  return result;
}

}  // namespace pavo::bench
