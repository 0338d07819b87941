// Descriptors of single windows, for the training: the same numbers that the dense scan multiplies.
#pragma once

#include <span>
#include <vector>

#include "stages/people/hog_rows.h"
#include "stages/people/pyramid.h"
#include "types/image.h"

namespace pavo::hog {

/// The descriptor of a window in a small picture. One per thread.
class CropDescriber {
 public:
  explicit CropDescriber(const Options& options) : options_(options) {}

  /// Describes the 64x128 window in the middle of `crop`, moved by (dx, dy) px, mirrored if asked for, into
  /// kDescriptorSize numbers. What of the window's surroundings the crop does not have is its edge, repeated. Throws
  /// std::invalid_argument if the crop is smaller than the window.
  void operator()(const Image& crop, int dx, int dy, bool mirrored, std::span<float> descriptor);

 private:
  Options options_;
  Image padded_;
  Pyramid pyramid_;
  HogRows rows_;
};

/// All blocks of one level, so that any of its windows can be described.
class LevelBlocks {
 public:
  void compute(const Pyramid& pyramid, const Level& level, const Options& options, HogRows& rows);

  /// The window at cell (x, y), 0 <= x < windows_x, 0 <= y < windows_y; kDescriptorSize numbers.
  void describe(int x, int y, std::span<float> descriptor) const;

  /// The row of blocks y, as HogRows::blocks().
  const float* row(int y) const { return blocks_.data() + static_cast<std::size_t>(y) * kBlockSize * stride_; }
  std::size_t stride() const { return stride_; }
  int rows() const { return rows_; }

 private:
  std::vector<float> blocks_;
  std::size_t stride_ = 0;
  int rows_ = 0;
};

}  // namespace pavo::hog
