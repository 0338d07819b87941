// What SURF needs to know about one keypoint size, worked out once.
#pragma once

#include <cstdint>

namespace pavo {

/// The keypoint's window of `window` x `window` pixels is shrunk to kGrid x kGrid samples by averaging areas, and the
/// kGrid - 1 gradients between the samples of a row (or column) fall into 4 cells of 5. One cell's 6 samples (the last
/// one is the next cell's first) lie in a block of 8 int16 lanes, so that neither a gradient nor a cell's sum crosses a
/// SIMD block: 32 lanes are a row.
struct SurfTables {
  static constexpr int kGrid = 21;
  static constexpr int kGradients = kGrid - 1;
  static constexpr int kCells = 4;
  static constexpr int kPerCell = kGradients / kCells;
  static constexpr int kBlock = 8;
  static constexpr int kLanes = kCells * kBlock;
  static constexpr int kMaxTaps = 4;
  static constexpr int kMaxWindow = 60;
  static constexpr int kOrientationRadius = 6;  ///< in units of s
  static constexpr int kOrientationSteps = 2 * kOrientationRadius + 1;

  SurfTables(double keypoint_size, bool oriented);

  float scale;  ///< s, in pixels
  bool oriented;
  int window;     ///< pixels a side
  int taps;       ///< how many pixels a sample's area can touch in one direction: 3 up to a shrinking of 2, else 4
  int support;    ///< how far from the keypoint a pixel can be that matters
  int row_bytes;  ///< how many bytes from a window row's first on are read

  /// Horizontal: sample = sum_k weight[k] * pixel[block_start + offset + k]. A sample's weights sum up to 2^16.
  int block_start[kCells];
  alignas(64) std::uint8_t shuffle[kMaxTaps][2 * kLanes];  ///< byte pairs (none, offset [+ k with 3 taps])
  alignas(64) std::uint16_t weight[kMaxTaps][kLanes];
  /// Vertical: the same with row_start.
  int row_start[kGrid];
  std::uint16_t row_weight[kGrid][kMaxTaps];
  /// The Gaussian of gradients, rows and lanes, such that the largest sum over a cell is 2^15.
  std::int16_t row_gaussian[kGradients];
  alignas(64) std::int16_t lane_gaussian[kLanes];

  /// The columns of the window, in steps of a vector: past its end, the last one again.
  alignas(64) std::int32_t column[64];

  /// Orientation: gradients by Haar wavelets of wavelet x wavelet pixels (even) at multiples of s in a circle,
  /// weighted.
  int wavelet;
  int circle[kOrientationSteps];  ///< the largest |step| in x that the circle has at a step in y
  std::int32_t orientation_weight[kOrientationSteps][kOrientationSteps];
};

}  // namespace pavo
