#include "stages/features/grid.h"

#include <algorithm>
#include <array>

namespace pavo {
namespace {

constexpr int kScores = 256;

/// The score of a cell's n-th strongest corner, n >= 1, and how many of the n have that very score.
struct Rank {
  int score;
  int ties;
};

template <class Count>
Rank nth_strongest(const Count* histogram, int n) {
  int score = kScores - 1;
  for (; n > static_cast<int>(histogram[score]); --score) n -= static_cast<int>(histogram[score]);
  return {score, n};
}

/// The largest number of corners that all cells may keep without their sum being more than `most`.
int common_quota(const std::vector<CornerGrid::Scratch::Cell>& cells, int most) {
  int low = 0, high = most;
  while (low < high) {
    const int quota = (low + high + 1) / 2;
    std::int64_t sum = 0;
    for (const auto& cell : cells) sum += std::min(cell.corners, quota);
    (sum <= most ? low : high) = sum <= most ? quota : quota - 1;
  }
  return low;
}

}  // namespace

CornerGrid::CornerGrid(int width, int height, int cell_size, int max_corners) : max_corners_(max_corners) {
  const int columns = (width + cell_size - 1) / cell_size;
  cells_ = columns * ((height + cell_size - 1) / cell_size);
  for (int x = 0; x < width; ++x) column_.push_back(x / cell_size);
  for (int y = 0; y < height; ++y) row_.push_back(y / cell_size * columns);
}

void CornerGrid::count(std::span<const Corner> corners, Scratch& scratch) const {
  scratch.cells.assign(static_cast<std::size_t>(cells_), {});
  scratch.histograms.assign(static_cast<std::size_t>(cells_) * kScores, 0);
  for (const Corner& corner : corners) {
    const int cell = cell_of(corner);
    ++scratch.cells[cell].corners;
    ++scratch.histograms[cell * kScores + corner.score];
  }
}

void CornerGrid::share_out(Scratch& scratch) const {
  const int quota = common_quota(scratch.cells, max_corners_);
  // One more would be too many in all; the rest goes to the cells whose next corner is strongest.
  int rest = max_corners_;
  std::array<int, kScores> next{};
  for (int i = 0; i < cells_; ++i) {
    Scratch::Cell& cell = scratch.cells[i];
    cell.quota = std::min(cell.corners, quota);
    rest -= cell.quota;
    if (cell.corners > quota) ++next[nth_strongest(&scratch.histograms[i * kScores], quota + 1).score];
  }
  Rank last{-1, 0};  // where no cell has more, nothing is left to give
  if (std::any_of(next.begin(), next.end(), [](int n) { return n > 0; })) last = nth_strongest(next.data(), rest);
  for (int i = 0; i < cells_; ++i) {
    Scratch::Cell& cell = scratch.cells[i];
    const std::uint16_t* histogram = &scratch.histograms[i * kScores];
    if (cell.corners > quota) {
      const int score = nth_strongest(histogram, quota + 1).score;
      cell.quota += score > last.score || (score == last.score && last.ties-- > 0);
    }
    if (cell.quota == 0) continue;
    const Rank rank = nth_strongest(histogram, cell.quota);
    cell.weakest = rank.score;
    cell.ties = rank.ties;
  }
}

std::span<Corner> CornerGrid::keep_best(std::span<Corner> corners, Scratch& scratch) const {
  scratch.cells.reserve(static_cast<std::size_t>(cells_));
  scratch.histograms.reserve(static_cast<std::size_t>(cells_) * kScores);
  if (corners.size() <= static_cast<std::size_t>(max_corners_)) return corners;
  count(corners, scratch);
  share_out(scratch);
  const auto end = std::remove_if(corners.begin(), corners.end(), [&](const Corner& corner) {
    Scratch::Cell& cell = scratch.cells[cell_of(corner)];
    if (cell.quota == 0 || corner.score < cell.weakest) return true;
    return corner.score == cell.weakest && cell.ties-- <= 0;
  });
  return {corners.begin(), end};
}

}  // namespace pavo
