// Keypoints and their descriptors: what a frame is remembered by.
#pragma once

#include <hwy/aligned_allocator.h>
#include <cstddef>
#include <vector>

namespace pavo {

struct Keypoint {
  float x = 0, y = 0;   ///< pixels, the centre of the top left pixel is (0, 0)
  float response = 0;   ///< FAST score: the largest threshold at which it is still a corner
  float angle_rad = 0;  ///< SURF's orientation; upright: 0
};

/// Up to `capacity` keypoints and, for each, kDescriptorSize floats of unit length (SURF-64; Bay et al., CVIU 2008).
/// The memory is allocated in reserve() and used again for every frame.
struct Features {
  static constexpr int kDescriptorSize = 64;

  std::vector<Keypoint> keypoints;
  hwy::AlignedFreeUniquePtr<float[]>
      descriptors;  ///< row i at 64 i, 64-byte aligned; only rows < keypoints.size() count
  std::size_t capacity = 0;

  void reserve(std::size_t n) {
    keypoints.reserve(n);
    if (n <= capacity) return;
    descriptors = hwy::AllocateAligned<float>(n * kDescriptorSize);
    capacity = n;
  }
  std::size_t size() const { return keypoints.size(); }
  float* descriptor(std::size_t i) { return descriptors.get() + i * kDescriptorSize; }
  const float* descriptor(std::size_t i) const { return descriptors.get() + i * kDescriptorSize; }
};

}  // namespace pavo
