// The linear classifier applied to all windows of a level, one row of blocks at a time.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "stages/people/hog.h"

namespace pavo::hog {

/// A classifier's weights in the order that the dense scan reads them. Immutable; shared by all threads.
class DenseWeights {
 public:
  /// `weights` in the order of descriptor_index(); exactly kDescriptorSize numbers, else std::invalid_argument.
  DenseWeights(std::span<const float> weights, float bias);

  const float* data() const { return data_.data(); }
  float bias() const { return bias_; }

 private:
  std::vector<float> data_;  // by block column, then number of the block, then block row
  float bias_;
};

/// score(x, y) = bias + sum over the window's blocks of weights . block. Each row of blocks is multiplied, as soon as
/// it is there, with all the rows of weights that meet it: a convolution, blocked for registers. In a fixed order of
/// summation, so the scores do not depend on who computes them.
class WindowScores {
 public:
  /// For a level with so many windows; allocates only for the largest so far.
  void start(const DenseWeights& weights, int windows_x, int windows_y);

  /// The next row of blocks: 36 planes of `stride` numbers, readable up to windows_x + kBlocksX - 1 rounded up to 64
  /// more.
  void add(const float* blocks, std::size_t stride);

  /// The scores of the row of windows that the last add() completed, or empty.
  std::span<const float> completed() const;
  int completed_row() const { return next_row_ - kBlocksY; }

 private:
  const DenseWeights* weights_ = nullptr;
  int windows_x_ = 0, windows_y_ = 0;
  int next_row_ = 0;        // of blocks
  std::size_t stride_ = 0;  // of scores_
  std::vector<float> scores_;
};

}  // namespace pavo::hog
