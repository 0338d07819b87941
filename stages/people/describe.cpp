#include "stages/people/describe.h"

#include <algorithm>
#include <stdexcept>

namespace pavo::hog {

void CropDescriber::operator()(const Image& crop, int dx, int dy, bool mirrored, std::span<float> descriptor) {
  if (crop.width() < kWindowWidth || crop.height() < kWindowHeight)
    throw std::invalid_argument("hog: a crop must have at least 64x128 pixels");
  // One cell around the window, because pixels vote into cells up to half a cell away.
  padded_.resize(kWindowWidth + 2 * kCell, kWindowHeight + 2 * kCell);
  const int left = (crop.width() - kWindowWidth) / 2 + dx - kCell,
            top = (crop.height() - kWindowHeight) / 2 + dy - kCell;
  for (int y = 0; y < padded_.height(); ++y) {
    const std::uint8_t* from = crop.row(std::clamp(top + y, 0, crop.height() - 1));
    std::uint8_t* to = padded_.row(y);
    for (int x = 0; x < padded_.width(); ++x) {
      const int at = std::clamp(left + x, 0, crop.width() - 1);
      to[mirrored ? padded_.width() - 1 - x : x] = from[at];
    }
  }
  pyramid_.plan(padded_.width(), padded_.height(), 2, options_.tone, Sampling::as_is);
  pyramid_.load(padded_.view());
  LevelBlocks blocks;
  blocks.compute(pyramid_, pyramid_.levels()[0], options_, rows_);
  blocks.describe(1, 1, descriptor);
}

void LevelBlocks::compute(const Pyramid& pyramid, const Level& level, const Options& options, HogRows& rows) {
  rows.start(pyramid, level, options);
  stride_ = rows.stride();
  rows_ = level.cells_y() - 1;
  const std::size_t size = kBlockSize * stride_;
  blocks_.resize(size * static_cast<std::size_t>(rows_));
  for (float* to = blocks_.data(); rows.next(); to += size) std::copy_n(rows.blocks(), size, to);
}

void LevelBlocks::describe(int x, int y, std::span<float> descriptor) const {
  float* out = descriptor.data();
  for (int by = 0; by < kBlocksY; ++by)
    for (int bx = 0; bx < kBlocksX; ++bx)
      for (std::size_t f = 0; f < kBlockSize; ++f) *out++ = row(y + by)[f * stride_ + static_cast<std::size_t>(x + bx)];
}

}  // namespace pavo::hog
