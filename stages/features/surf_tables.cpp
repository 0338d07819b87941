#include "stages/features/surf_tables.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

namespace pavo {
namespace {

/// Which pixels the sample `index` averages, and with which shares of 1.
struct Area {
  int first;
  double share[SurfTables::kMaxTaps];
};

Area area_of(int index, int window) {
  const double size = static_cast<double>(window) / SurfTables::kGrid;
  // The start as an exact fraction: no pixel may get a share by rounding.
  const int first = index * window / SurfTables::kGrid;
  const double begin = index * size;
  Area area{first, {}};
  for (int k = 0; k < SurfTables::kMaxTaps; ++k) {
    const double overlap = std::min(begin + size, first + k + 1.0) - std::max(begin, static_cast<double>(first + k));
    area.share[k] = overlap > 1e-9 ? overlap / size : 0;
  }
  return area;
}

/// Integers of sum `whole` in proportion to the shares; what rounding left over goes to the largest.
void quantise(const Area& area, int whole, int* out) {
  for (int k = 0; k < SurfTables::kMaxTaps; ++k) out[k] = static_cast<int>(std::lround(area.share[k] * whole));
  *std::max_element(out, out + SurfTables::kMaxTaps) += whole - std::accumulate(out, out + SurfTables::kMaxTaps, 0);
}

void fill_horizontal(SurfTables& t) {
  for (int cell = 0; cell < SurfTables::kCells; ++cell) {
    t.block_start[cell] = area_of(cell * SurfTables::kPerCell, t.window).first;
    for (int i = 0; i < SurfTables::kBlock; ++i) {
      const int lane = cell * SurfTables::kBlock + i;
      const Area area = area_of(cell * SurfTables::kPerCell + std::min(i, SurfTables::kPerCell), t.window);
      int weights[SurfTables::kMaxTaps];
      quantise(area, 65536, weights);
      for (int k = 0; k < SurfTables::kMaxTaps; ++k) {
        const bool used = i <= SurfTables::kPerCell && weights[k] != 0;
        const int offset = area.first - t.block_start[cell] + (t.taps == 3 ? k : 0);
        t.shuffle[k][2 * lane] = 0x80;
        t.shuffle[k][2 * lane + 1] = static_cast<std::uint8_t>(used ? offset : 0x80);
        t.weight[k][lane] = static_cast<std::uint16_t>(used ? weights[k] : 0);
      }
    }
  }
}

void fill_vertical(SurfTables& t) {
  for (int i = 0; i < SurfTables::kGrid; ++i) {
    const Area area = area_of(i, t.window);
    int weights[SurfTables::kMaxTaps];
    quantise(area, 65536, weights);
    // The last area's taps may reach past the window with weight 0: read rows that exist instead.
    const int shift = std::max(0, area.first + t.taps - t.window);
    t.row_start[i] = area.first - shift;
    for (int k = 0; k < SurfTables::kMaxTaps; ++k) {
      t.row_weight[i][k] = static_cast<std::uint16_t>(k >= shift ? weights[k - shift] : 0);
    }
  }
}

void fill_gaussian(SurfTables& t) {
  double g[SurfTables::kGradients];
  for (int i = 0; i < SurfTables::kGradients; ++i) {
    const double x = i - 0.5 * (SurfTables::kGradients - 1);
    g[i] = std::exp(-x * x / (2 * 3.3 * 3.3));
  }
  const double largest = std::accumulate(g + SurfTables::kPerCell, g + 2 * SurfTables::kPerCell, 0.0);
  for (int i = 0; i < SurfTables::kGradients; ++i) {
    t.row_gaussian[i] = static_cast<std::int16_t>(std::lround(g[i] / largest * 32767));
  }
  std::fill(std::begin(t.lane_gaussian), std::end(t.lane_gaussian), std::int16_t{0});
  for (int i = 0; i < SurfTables::kGradients; ++i) {
    t.lane_gaussian[i / SurfTables::kPerCell * SurfTables::kBlock + i % SurfTables::kPerCell] = t.row_gaussian[i];
  }
}

void fill_orientation(SurfTables& t) {
  constexpr int r = SurfTables::kOrientationRadius;
  t.wavelet = 2 * static_cast<int>(std::lrint(2 * t.scale));
  for (int y = -r; y <= r; ++y) {
    t.circle[y + r] = static_cast<int>(std::sqrt(r * r - y * y));
    for (int x = -r; x <= r; ++x) {
      // 2^11 at most: 113 of them times the largest response of the largest wavelet stay within 31 bits.
      t.orientation_weight[y + r][x + r] =
          static_cast<std::int32_t>(std::lround(2047 * std::exp(-(x * x + y * y) / (2 * 2.5 * 2.5))));
    }
  }
}

}  // namespace

SurfTables::SurfTables(double keypoint_size, bool is_oriented) {
  scale = static_cast<float>(keypoint_size) * 1.2f / 9.0f;
  oriented = is_oriented;
  window = static_cast<int>(static_cast<float>(kGrid) * scale);
  taps = window <= 2 * kGrid ? 3 : 4;
  for (int i = 0; i < 64; ++i) column[i] = std::min(i, window - 1);
  fill_horizontal(*this);
  fill_vertical(*this);
  fill_gaussian(*this);
  fill_orientation(*this);
  row_bytes = block_start[kCells - 1] + 16 + (taps == 3 ? 0 : taps - 1);
  support = window / 2;
  if (oriented) {
    const double corner = std::sqrt(0.5) * (window - 1);
    const double response = kOrientationRadius * static_cast<double>(scale) + wavelet / 2 + 1;
    support = static_cast<int>(std::ceil(std::max(corner, response))) + 1;
  }
}

}  // namespace pavo
