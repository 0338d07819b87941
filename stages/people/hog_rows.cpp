#include "stages/people/hog_rows.h"

#include <algorithm>

#include "stages/people/hog_cells.h"

namespace pavo::hog {
namespace {

// A cell's number is a sum of votes, each sin(20 deg) |g|, with weights in 1/16; g in units of 255 / kPixelMax gray
// levels over two pixels.
constexpr float kCellsPerGrayLevel = 0.34202014f * 16 * kPixelMax / 255;

constexpr std::size_t round_up(std::size_t n, std::size_t to) {
  return (n + to - 1) / to * to;
}

}  // namespace

void HogRows::start(const Pyramid& pyramid, const Level& level, const Options& options, int first_row) {
  pyramid_ = &pyramid;
  level_ = &level;
  options_ = options;
  epsilon_ = options.epsilon * kCellsPerGrayLevel;
  row_size_ = Pyramid::row_size(level);
  const auto cells_x = static_cast<std::size_t>(level.cells_x());
  // The scan reads blocks up to the last window's last column, in vectors, four at once.
  stride_ = round_up(cells_x, 16) + 64;
  plane_ = 4 * (round_up(cells_x + 1, 8) + 16);
  cells_size_ = (kBins + 1) * stride_ + 16;
  pixels_.reserve(kRing * row_size_);
  blended_.reserve(pyramid.blended_size());
  sums_.reserve(kBins * plane_);
  carry_.reserve(kBins * stride_);
  cells_.reserve(2 * cells_size_);
  blocks_.reserve(kBlockSize * stride_);
  std::fill_n(carry_.data(), kBins * stride_, 0);
  std::fill_n(cells_.data(), 2 * cells_size_, 0.0f);
  begun_ = false;
  next_band_ = first_row;
  loaded_until_ = kCell * first_row - kCell / 2 - 2;
}

void HogRows::load_rows_until(int y) {
  while (loaded_until_ < y) {
    ++loaded_until_;
    pyramid_->row(*level_, loaded_until_,
                  pixels_.data() + static_cast<std::size_t>(loaded_until_ & (kRing - 1)) * row_size_, blended_.data());
  }
}

// Band b lies between cell rows b - 1 and b: pixel rows 8 b - 4 to 8 b + 3. It completes cell row b - 1.
void HogRows::add_band(int band, int cell_row) {
  const int first = kCell * band - kCell / 2;
  load_rows_until(first + kCell);
  const std::int16_t* rows[kCell + 2];
  for (int i = 0; i < kCell + 2; ++i) {
    const int y = first - 1 + i;
    rows[i] = pixels_.data() + static_cast<std::size_t>(y & (kRing - 1)) * row_size_ + Level::kMargin - kCell / 2;
  }
  const BandSums sums{sums_.data(), plane_};
  vote_band(rows, level_->cells_x() + 1, sums);
  gather_cells(sums, level_->cells_x(), stride_, carry_.data(), cells(cell_row), energy(cell_row));
}

bool HogRows::next() {
  // The first band only votes into what is carried to the row of cells below it; the next two complete two rows.
  const int last_band = begun_ ? next_band_ : next_band_ + 2;
  if (last_band > level_->cells_y()) return false;
  for (int band = next_band_; band <= last_band; ++band) add_band(band, band - 1);
  begun_ = true;
  next_band_ = last_band + 1;
  const int lower = last_band - 1, upper = lower - 1;
  normalise_blocks(cells(upper), energy(upper), cells(lower), energy(lower),
                   static_cast<std::size_t>(level_->cells_x()), stride_, epsilon_, options_.clip, options_.fade,
                   blocks_.data());
  return true;
}

}  // namespace pavo::hog
