#include "stages/people/window_scores.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/people/window_scores.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pavo::hog {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// scores[-j * stride] += sum over block columns and numbers of blocks * weights[j], j < kRows, for kVectors vectors of
/// windows side by side. Every loaded vector of blocks is used kRows times, every weight kVectors times.
template <int kVectors, int kRows>
HWY_INLINE void Accumulate(const float* HWY_RESTRICT blocks, std::size_t block_stride,
                           const float* HWY_RESTRICT weights, float* HWY_RESTRICT scores, std::ptrdiff_t stride) {
  const hn::ScalableTag<float> d;
  const std::size_t lanes = hn::Lanes(d);
  hn::Vec<decltype(d)> sum[kVectors][kRows];
  for (int v = 0; v < kVectors; ++v)
    for (int j = 0; j < kRows; ++j) sum[v][j] = hn::Zero(d);
  for (int column = 0; column < kBlocksX; ++column) {
    const float* block = blocks + column;
    for (int f = 0; f < kBlockSize; ++f, block += block_stride, weights += kBlocksY) {
      hn::Vec<decltype(d)> value[kVectors];
      for (std::size_t v = 0; v < kVectors; ++v) value[v] = hn::LoadU(d, block + v * lanes);
      for (int j = 0; j < kRows; ++j) {
        const auto weight = hn::Set(d, weights[j]);
        for (int v = 0; v < kVectors; ++v) sum[v][j] = hn::MulAdd(value[v], weight, sum[v][j]);
      }
    }
  }
  for (int j = 0; j < kRows; ++j)
    for (int v = 0; v < kVectors; ++v) {
      float* to = scores - j * stride + v * static_cast<std::ptrdiff_t>(lanes);
      hn::StoreU(hn::Add(hn::LoadU(d, to), sum[v][j]), d, to);
    }
}

template <int kVectors>
HWY_INLINE void AccumulateRows(int rows, const float* blocks, std::size_t block_stride, const float* weights,
                               float* scores, std::ptrdiff_t stride) {
  switch (rows) {
    case 1:
      return Accumulate<kVectors, 1>(blocks, block_stride, weights, scores, stride);
    case 2:
      return Accumulate<kVectors, 2>(blocks, block_stride, weights, scores, stride);
    case 3:
      return Accumulate<kVectors, 3>(blocks, block_stride, weights, scores, stride);
    case 4:
      return Accumulate<kVectors, 4>(blocks, block_stride, weights, scores, stride);
    default:
      return Accumulate<kVectors, 5>(blocks, block_stride, weights, scores, stride);
  }
}

/// Block row `row` is row `by` of the windows that begin at row - by, for by in [first, last].
void AddBlockRow(const float* blocks, std::size_t block_stride, const float* weights, int row, int first, int last,
                 int windows_x, float* all_scores, std::ptrdiff_t stride) {
  const hn::ScalableTag<float> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  constexpr bool kManyRegisters = HWY_TARGET <= HWY_AVX3 || HWY_TARGET == HWY_NEON;
  const int vectors = (windows_x + lanes - 1) / lanes;
  for (int by = first; by <= last; by += 5) {
    const int rows = std::min(5, last - by + 1);
    float* scores = all_scores + (row - by) * stride;
    const float* w = weights + by;
    int v = 0;
    if constexpr (kManyRegisters)
      for (; v + 4 <= vectors; v += 4)
        AccumulateRows<4>(rows, blocks + v * lanes, block_stride, w, scores + v * lanes, stride);
    for (; v + 2 <= vectors; v += 2)
      AccumulateRows<2>(rows, blocks + v * lanes, block_stride, w, scores + v * lanes, stride);
    if (v < vectors) AccumulateRows<1>(rows, blocks + v * lanes, block_stride, w, scores + v * lanes, stride);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace pavo::hog
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pavo::hog {

HWY_EXPORT(AddBlockRow);

DenseWeights::DenseWeights(std::span<const float> weights, float bias) : data_(kDescriptorSize), bias_(bias) {
  if (weights.size() != kDescriptorSize) throw std::invalid_argument("hog: a classifier has 3780 weights");
  for (int by = 0; by < kBlocksY; ++by)
    for (int bx = 0; bx < kBlocksX; ++bx)
      for (int f = 0; f < kBlockSize; ++f)
        data_[static_cast<std::size_t>((bx * kBlockSize + f) * kBlocksY + by)] =
            weights[static_cast<std::size_t>((by * kBlocksX + bx) * kBlockSize + f)];
}

void WindowScores::start(const DenseWeights& weights, int windows_x, int windows_y) {
  weights_ = &weights;
  windows_x_ = windows_x;
  windows_y_ = windows_y;
  next_row_ = 0;
  stride_ = (static_cast<std::size_t>(windows_x) + 63) / 64 * 64;
  scores_.assign(stride_ * static_cast<std::size_t>(windows_y), weights.bias());
}

void WindowScores::add(const float* blocks, std::size_t stride) {
  const int row = next_row_++;
  const int first = std::max(0, row - windows_y_ + 1), last = std::min(row, kBlocksY - 1);
  HWY_DYNAMIC_DISPATCH(AddBlockRow)
  (blocks, stride, weights_->data(), row, first, last, windows_x_, scores_.data(),
   static_cast<std::ptrdiff_t>(stride_));
}

std::span<const float> WindowScores::completed() const {
  const int row = completed_row();
  if (row < 0 || row >= windows_y_) return {};
  return {scores_.data() + stride_ * static_cast<std::size_t>(row), static_cast<std::size_t>(windows_x_)};
}

}  // namespace pavo::hog
#endif
