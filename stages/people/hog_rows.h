// The blocks of one level of the pyramid, row by row: what both the dense scan and the training read.
#pragma once

#include <hwy/aligned_allocator.h>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>

#include "stages/people/hog.h"
#include "stages/people/pyramid.h"

namespace pavo::hog {

/// Aligned memory that only grows; zero at first.
template <typename T>
class Buffer {
 public:
  void reserve(std::size_t n) {
    if (n <= capacity_) return;
    data_ = hwy::AllocateAligned<T>(n);
    if (!data_) throw std::bad_alloc();
    std::uninitialized_fill_n(data_.get(), n, T{0});
    capacity_ = n;
  }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }

 private:
  hwy::AlignedFreeUniquePtr<T[]> data_;
  std::size_t capacity_ = 0;
};

/// A generator: start(), then next() as long as it is true. A row of blocks lives in the cache until the next one; the
/// whole HOG of a level is never stored. One object per thread. Allocates only for a level wider than any before.
class HogRows {
 public:
  /// The first row of blocks will be `first_row`: what is above it is not computed.
  void start(const Pyramid& pyramid, const Level& level, const Options& options, int first_row = 0);

  /// Computes the next row of blocks; false after the last one (row cells_y - 2).
  bool next();

  /// 36 planes of stride() numbers, plane (2 cell_y + cell_x) kBins + bin; number x belongs to the block at cell x.
  /// Valid for x < cells_x - 1, readable for stride().
  const float* blocks() const { return blocks_.data(); }
  std::size_t stride() const { return stride_; }

 private:
  void load_rows_until(int y);
  void add_band(int band, int cell_row);
  float* cells(int cell_row) { return cells_.data() + static_cast<std::size_t>(cell_row & 1) * cells_size_; }
  float* energy(int cell_row) { return cells(cell_row) + kBins * stride_; }

  static constexpr int kRing = 16;  // rows of pixels; a band needs 10

  const Pyramid* pyramid_ = nullptr;
  const Level* level_ = nullptr;
  Options options_;
  float epsilon_ = 0;  // in units of the cells
  bool begun_ = false;
  int next_band_ = 0;
  int loaded_until_ = 0;  // rows of pixels up to this one are in the ring
  std::size_t row_size_ = 0, stride_ = 0, plane_ = 0, cells_size_ = 0;
  Buffer<std::int16_t> pixels_;  // kRing rows
  Buffer<std::int16_t> blended_;
  Buffer<std::int32_t> sums_;   // kBins planes of plane_
  Buffer<std::int32_t> carry_;  // kBins planes of stride_
  Buffer<float> cells_;         // two rows of cells: kBins planes and their energy
  Buffer<float> blocks_;        // kBlockSize planes of stride_
};

}  // namespace pavo::hog
