#include "stages/features/surf.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>

#include "stages/features/surf_orientation.h"
#include "stages/features/surf_tables.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/features/surf.cpp"
#include <hwy/foreach_target.h>  // compiles the part below once for every SIMD target
#include <hwy/highway.h>

#ifndef PAVO_STAGES_FEATURES_SURF_ONCE
#define PAVO_STAGES_FEATURES_SURF_ONCE
namespace pavo {

/// A keypoint's pixels as the image holds them, or cut out, clamped or rotated, into a buffer.
struct Window {
  const std::uint8_t* pixels;
  std::ptrdiff_t stride;
};

inline constexpr int kWindowStride = 64;

/// Rows of kWindowStride bytes, and one more for the vectors that read past the last row's end.
struct WindowBuffer {
  alignas(64) std::uint8_t pixels[(SurfTables::kMaxWindow + 1) * kWindowStride];
};

/// Where the pixel (column c, row r) of a rotated window lies relative to a keypoint's integer position: start + c *
/// column
/// + r * row, in 2^-16 pixels.
struct Rotation {
  std::int32_t start_x, start_y, column_x, column_y, row_x, row_y;
};

}  // namespace pavo
#endif

HWY_BEFORE_NAMESPACE();
namespace pavo::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes16 = hn::CappedTag<std::int16_t, SurfTables::kLanes>;  // a row's 32 lanes are 1, 2 or 4 vectors
using LanesU16 = hn::RebindToUnsigned<Lanes16>;
using Lanes32 = hn::RepartitionToWide<Lanes16>;
using Bytes = hn::Repartition<std::uint8_t, Lanes16>;

/// 16 bytes for each 128-bit block of a vector, each block from its own place.
template <class D>
HWY_INLINE hn::Vec<D> load_blocks(D d, const std::uint8_t* from, const int* start) {
  if constexpr (hn::MaxLanes(d) == 16) {
    return hn::LoadU(d, from + start[0]);
  } else {
    const hn::Half<D> half;
    constexpr std::size_t blocks = hn::MaxLanes(half) / 16;
    return hn::Combine(d, load_blocks(half, from, start + blocks), load_blocks(half, from, start));
  }
}

/// Shrinks the window's rows to the grid's columns, in the lanes' order, in units of 2^-8 gray levels. The shuffle puts
/// a pixel into the upper byte of its lane, so that the upper half of the product has the unit 2^-8.
template <int kTaps>
HWY_INLINE void shrink_rows(const SurfTables& t, Window window, std::uint16_t* HWY_RESTRICT out) {
  const LanesU16 d;
  const Bytes d8;
  for (std::size_t lane = 0; lane < SurfTables::kLanes; lane += hn::Lanes(d)) {
    const int* start = t.block_start + lane / SurfTables::kBlock;
    hn::Vec<Bytes> shuffle[kTaps];
    hn::Vec<LanesU16> weight[kTaps];
    for (int k = 0; k < kTaps; ++k) {
      shuffle[k] = hn::Load(d8, t.shuffle[k] + 2 * lane);
      weight[k] = hn::Load(d, t.weight[k] + lane);
    }
    const std::uint8_t* row = window.pixels;
    for (int y = 0; y < t.window; ++y, row += window.stride) {
      auto bytes = load_blocks(d8, row, start);
      auto sum = hn::MulHigh(hn::BitCast(d, hn::TableLookupBytesOr0(bytes, shuffle[0])), weight[0]);
      for (int k = 1; k < kTaps; ++k) {
        if (kTaps > 3) bytes = load_blocks(d8, row + k, start);
        sum = hn::Add(sum, hn::MulHigh(hn::BitCast(d, hn::TableLookupBytesOr0(bytes, shuffle[k])), weight[k]));
      }
      hn::Store(sum, d, out + y * SurfTables::kLanes + lane);
    }
  }
}

/// One row of the grid from the shrunk rows, rounded to whole gray levels, in units of 2^-6 of them.
template <int kTaps>
HWY_INLINE hn::Vec<Lanes16> grid_row(const SurfTables& t, const std::uint16_t* HWY_RESTRICT rows, int i) {
  const LanesU16 d;
  const std::uint16_t* from = rows + t.row_start[i] * SurfTables::kLanes;
  auto sum = hn::Set(d, 128 + 2);  // a half, and what the products lost on average by being cut off
  for (int k = 0; k < kTaps; ++k) {
    const auto row = hn::Load(d, from + k * SurfTables::kLanes);
    sum = hn::Add(sum, hn::MulHigh(row, hn::Set(d, t.row_weight[i][k])));
  }
  return hn::BitCast(Lanes16(), hn::ShiftLeft<6>(hn::ShiftRight<8>(sum)));
}

/// Per block the sum of its lanes, each times its weight; what four vectors give stands next to each other.
template <class V>
HWY_INLINE hn::Vec<Lanes32> sum_blocks(V a, V b, V c, V e, V weight) {
  const Lanes32 d;
  const auto pairs = [&](V v) {
    auto rest = hn::Zero(d);
    const auto sum = hn::ReorderWidenMulAccumulate(d, v, weight, hn::Zero(d), rest);
    return hn::Add(sum, rest);
  };
  const auto pa = pairs(a), pb = pairs(b), pc = pairs(c), pe = pairs(e);
  const auto ac = hn::Add(hn::InterleaveLower(d, pa, pc), hn::InterleaveUpper(d, pa, pc));
  const auto be = hn::Add(hn::InterleaveLower(d, pb, pe), hn::InterleaveUpper(d, pb, pe));
  return hn::Add(hn::InterleaveLower(d, ac, be), hn::InterleaveUpper(d, ac, be));
}

/// cells[4 * row + column]: the weighted sums of the gradients up (dx of a direction of -y), right (dy), and of their
/// sizes.
template <int kTaps>
HWY_INLINE void sum_cells(const SurfTables& t, const std::uint16_t* HWY_RESTRICT rows, std::int32_t (*cells)[4]) {
  const Lanes16 d;
  for (std::size_t lane = 0; lane < SurfTables::kLanes; lane += hn::Lanes(d)) {
    const auto weight = hn::Load(d, t.lane_gaussian + lane);
    const auto first = grid_row<kTaps>(t, rows, 0);
    const auto first_next = hn::ShiftRightLanes<1>(d, first);
    auto sum_above = hn::Add(first, first_next);
    auto step_above = hn::Sub(first_next, first);
    for (int cell = 0; cell < SurfTables::kCells; ++cell) {
      auto up_sum = hn::Zero(d), right_sum = hn::Zero(d), up_size = hn::Zero(d), right_size = hn::Zero(d);
      for (int i = cell * SurfTables::kPerCell; i < (cell + 1) * SurfTables::kPerCell; ++i) {
        const auto row = grid_row<kTaps>(t, rows, i + 1);
        const auto next = hn::ShiftRightLanes<1>(d, row);
        const auto sum = hn::Add(row, next);
        const auto step = hn::Sub(next, row);
        const auto up = hn::Sub(sum_above, sum);
        const auto right = hn::Add(step_above, step);
        const auto gaussian = hn::Set(d, t.row_gaussian[i]);
        up_sum = hn::Add(up_sum, hn::MulFixedPoint15(up, gaussian));
        right_sum = hn::Add(right_sum, hn::MulFixedPoint15(right, gaussian));
        up_size = hn::Add(up_size, hn::MulFixedPoint15(hn::Abs(up), gaussian));
        right_size = hn::Add(right_size, hn::MulFixedPoint15(hn::Abs(right), gaussian));
        sum_above = sum;
        step_above = step;
      }
      const auto sums = sum_blocks(up_sum, right_sum, up_size, right_size, weight);
      hn::Store(sums, Lanes32(), cells[cell * SurfTables::kCells + static_cast<int>(lane) / SurfTables::kBlock]);
    }
    rows += hn::Lanes(d);
  }
}

/// The cells as a vector of unit length, counted across the direction -y first. Sums of 4 lanes on every target.
HWY_INLINE void normalise(const std::int32_t (*cells)[4], float* HWY_RESTRICT out) {
  const hn::FixedTag<std::int32_t, 4> di;
  const hn::FixedTag<float, 4> df;
  hn::Vec<decltype(df)> v[16];
  auto squares = hn::Zero(df);
  for (int i = 0; i < 16; ++i) {
    v[i] = hn::ConvertTo(df, hn::Load(di, cells[i]));
    squares = hn::Add(squares, hn::Mul(v[i], v[i]));
  }
  alignas(16) float s[4];
  hn::Store(squares, df, s);
  const float length = std::sqrt((s[0] + s[1]) + (s[2] + s[3]));
  const auto scale = hn::Set(df, length > 0 ? 1.0f / length : 0.0f);
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      hn::Store(hn::Mul(v[4 * row + column], scale), df, out + 4 * (4 * column + 3 - row));
    }
  }
}

template <int kTaps>
HWY_INLINE void describe(const SurfTables& t, Window window, float* HWY_RESTRICT out) {
  alignas(64) std::uint16_t rows[SurfTables::kMaxWindow * SurfTables::kLanes];
  alignas(64) std::int32_t cells[SurfTables::kCells * SurfTables::kCells][4];
  shrink_rows<kTaps>(t, window, rows);
  sum_cells<kTaps>(t, rows, cells);
  normalise(cells, out);
}

void describe_window(const SurfTables& t, Window window, float* out) {
  t.taps == 3 ? describe<3>(t, window, out) : describe<4>(t, window, out);
}

using LanesSample = hn::CappedTag<std::int32_t, 16>;

/// Calls sample(first column, row, x, y) for vectors of a rotated window's pixels; x, y in 2^-16 pixels. The lanes past
/// the window's end repeat its last column.
template <class Sample>
HWY_INLINE void for_samples(const SurfTables& t, const Rotation& rotation, const Sample& sample) {
  const LanesSample d;
  for (int c = 0; c < t.window; c += static_cast<int>(hn::Lanes(d))) {
    const auto column = hn::Load(d, t.column + c);
    auto x = hn::Add(hn::Set(d, rotation.start_x), hn::Mul(column, hn::Set(d, rotation.column_x)));
    auto y = hn::Add(hn::Set(d, rotation.start_y), hn::Mul(column, hn::Set(d, rotation.column_y)));
    for (int r = 0; r < t.window; ++r) {
      sample(c, r, x, y);
      x = hn::Add(x, hn::Set(d, rotation.row_x));
      y = hn::Add(y, hn::Set(d, rotation.row_y));
    }
  }
}

/// Bilinear samples of a rotated window that lies within the image; `origin` is the pixel that the rotation is relative
/// to. First where all the samples are, then their pixels, then their values: a vector that is loaded right after its
/// lanes were stored one by one would wait for them.
void rotate_window(const SurfTables& t, const Rotation& rotation, const std::uint8_t* origin, std::ptrdiff_t stride,
                   std::uint8_t* HWY_RESTRICT out) {
  const LanesSample d;
  const hn::RebindToUnsigned<LanesSample> du;
  const hn::RebindToFloat<LanesSample> df;
  const hn::Rebind<std::uint8_t, LanesSample> d8;
  alignas(64) std::int32_t offsets[SurfTables::kMaxWindow * kWindowStride];
  alignas(64) std::uint32_t pixels[SurfTables::kMaxWindow * kWindowStride];
  const auto pitch = hn::Set(d, static_cast<std::int32_t>(stride));
  for_samples(t, rotation, [&](int c, int r, auto x, auto y) HWY_ATTR {
    const auto offset = hn::Add(hn::Mul(hn::ShiftRight<16>(y), pitch), hn::ShiftRight<16>(x));
    hn::Store(offset, d, offsets + r * kWindowStride + c);
  });
  for (int r = 0; r < t.window; ++r) {
    for (int i = r * kWindowStride; i < r * kWindowStride + t.window; ++i) {
      std::uint16_t above, below;
      std::memcpy(&above, origin + offsets[i], 2);
      std::memcpy(&below, origin + offsets[i] + stride, 2);
      pixels[i] = above | static_cast<std::uint32_t>(below) << 16;
    }
  }
  for_samples(t, rotation, [&](int c, int r, auto x, auto y) HWY_ATTR {
    const auto four = hn::Load(du, pixels + r * kWindowStride + c);
    const auto gray = [&](auto byte)
                          HWY_ATTR { return hn::ConvertTo(df, hn::BitCast(d, hn::And(byte, hn::Set(du, 255)))); };
    const auto fraction = [&](auto v) HWY_ATTR {
      return hn::Mul(hn::ConvertTo(df, hn::And(v, hn::Set(d, 65535))), hn::Set(df, 1.0f / 65536));
    };
    // No fused multiply-add: the same bits on every target.
    const auto between = [](auto a, auto b, auto f) HWY_ATTR { return hn::Add(a, hn::Mul(hn::Sub(b, a), f)); };
    const auto fx = fraction(x);
    const auto above = between(gray(four), gray(hn::ShiftRight<8>(four)), fx);
    const auto below = between(gray(hn::ShiftRight<16>(four)), gray(hn::ShiftRight<24>(four)), fx);
    const auto value = hn::NearestInt(between(above, below, fraction(y)));
    hn::StoreU(hn::DemoteTo(d8, value), d8, out + r * kWindowStride + c);
  });
}

}  // namespace pavo::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pavo {
HWY_EXPORT(describe_window);
HWY_EXPORT(rotate_window);

namespace {

int nearest(float x) {
  return static_cast<int>(std::lrint(x));
}

/// The upright window around a keypoint: a part of the image, or a copy where the image does not go on.
Window upright_window(const SurfTables& t, ImageView image, const Keypoint& keypoint, WindowBuffer& buffer) {
  const float half = 0.5f * static_cast<float>(t.window - 1);
  const int left = nearest(keypoint.x - half);
  const int top = nearest(keypoint.y + half) - t.window + 1;
  const bool inside = left >= 0 && top >= 0 && left + t.row_bytes <= image.width && top + t.window <= image.height;
  if (inside) return {image.row(top) + left, image.stride};
  for (int y = 0; y < t.window; ++y) {
    const std::uint8_t* row = image.row(std::clamp(top + y, 0, image.height - 1));
    std::uint8_t* out = buffer.pixels + y * kWindowStride;
    for (int x = 0; x < t.window; ++x) out[x] = row[std::clamp(left + x, 0, image.width - 1)];
  }
  return {buffer.pixels, kWindowStride};
}

/// Columns of the window run across the direction, rows against it: as an upright window's, whose direction is -y.
Rotation rotation_of(const SurfTables& t, Direction direction, float fraction_x, float fraction_y) {
  const float length = std::sqrt(direction.x * direction.x + direction.y * direction.y);
  const float c = length > 0 ? direction.x / length : 1.0f;
  const float s = length > 0 ? direction.y / length : 0.0f;
  const float half = 0.5f * static_cast<float>(t.window - 1);
  const auto fixed = [](float x) { return static_cast<std::int32_t>(std::lrint(x * 65536.0f)); };
  return {fixed(fraction_x + half * (c + s)),
          fixed(fraction_y + half * (s - c)),
          fixed(-s),
          fixed(c),
          fixed(-c),
          fixed(-s)};
}

/// The same as rotate_window(), for a window that leaves the image.
void rotate_window_at_border(const SurfTables& t, const Rotation& rotation, ImageView image, int x0, int y0,
                             std::uint8_t* out) {
  const auto pixel = [&](int x, int y) -> float {
    return image.at(std::clamp(x, 0, image.width - 1), std::clamp(y, 0, image.height - 1));
  };
  for (int r = 0; r < t.window; ++r) {
    for (int c = 0; c < t.window; ++c) {
      const int fixed_x = rotation.start_x + c * rotation.column_x + r * rotation.row_x;
      const int fixed_y = rotation.start_y + c * rotation.column_y + r * rotation.row_y;
      const int x = x0 + (fixed_x >> 16), y = y0 + (fixed_y >> 16);
      const float fx = static_cast<float>(fixed_x & 65535) / 65536, fy = static_cast<float>(fixed_y & 65535) / 65536;
      const float above = pixel(x, y) + (pixel(x + 1, y) - pixel(x, y)) * fx;
      const float below = pixel(x, y + 1) + (pixel(x + 1, y + 1) - pixel(x, y + 1)) * fx;
      out[r * kWindowStride + c] = static_cast<std::uint8_t>(nearest(above + (below - above) * fy));
    }
  }
}

Window oriented_window(const SurfTables& t, ImageView image, const Keypoint& keypoint, Direction direction,
                       WindowBuffer& buffer) {
  const int x = static_cast<int>(std::floor(keypoint.x)), y = static_cast<int>(std::floor(keypoint.y));
  const Rotation rotation =
      rotation_of(t, direction, keypoint.x - static_cast<float>(x), keypoint.y - static_cast<float>(y));
  const int reach = t.support + 1;
  if (x >= reach && y >= reach && x + reach < image.width && y + reach < image.height) {
    HWY_DYNAMIC_DISPATCH(rotate_window)(t, rotation, image.row(y) + x, image.stride, buffer.pixels);
  } else {
    rotate_window_at_border(t, rotation, image, x, y, buffer.pixels);
  }
  return {buffer.pixels, kWindowStride};
}

void reserve(Surf::Scratch& scratch, ImageView image) {
  const std::size_t size = (static_cast<std::size_t>(image.width) + 1) * (static_cast<std::size_t>(image.height) + 1);
  if (scratch.size >= size) return;
  scratch.integral = hwy::AllocateAligned<std::uint32_t>(size);
  scratch.size = size;
}

void describe_upright(const SurfTables& t, ImageView image, Features& features) {
  WindowBuffer buffer{};
  for (std::size_t i = 0; i < features.size(); ++i) {
    Keypoint& keypoint = features.keypoints[i];
    keypoint.angle_rad = 0;
    HWY_DYNAMIC_DISPATCH(describe_window)
    (t, upright_window(t, image, keypoint, buffer), features.descriptor(i));
  }
}

void describe_oriented(const SurfTables& t, ImageView image, Features& features, Surf::Scratch& scratch) {
  const Integral integral = make_integral(image, scratch.integral.get());
  WindowBuffer buffer{};
  for (std::size_t i = 0; i < features.size(); ++i) {
    Keypoint& keypoint = features.keypoints[i];
    const Direction direction = dominant_gradient(t, integral, keypoint.x, keypoint.y);
    keypoint.angle_rad = std::atan2(direction.y, direction.x);
    HWY_DYNAMIC_DISPATCH(describe_window)
    (t, oriented_window(t, image, keypoint, direction, buffer), features.descriptor(i));
  }
}

}  // namespace

Surf::Surf(double keypoint_size, bool oriented) {
  if (!(keypoint_size >= kSmallestSize && keypoint_size <= kLargestSize)) {
    throw std::runtime_error("SURF: keypoint size " + std::to_string(keypoint_size) + ": expected 9 to 21 pixels");
  }
  tables_ = std::make_unique<const SurfTables>(keypoint_size, oriented);
}

Surf::~Surf() = default;
Surf::Surf(Surf&&) noexcept = default;
Surf& Surf::operator=(Surf&&) noexcept = default;

int Surf::support() const {
  return tables_->support;
}

void Surf::operator()(ImageView image, Features& features, Scratch& scratch) const {
  if (tables_->oriented) reserve(scratch, image);
  if (features.size() == 0) return;
  features.reserve(features.size());
  if (tables_->oriented) {
    describe_oriented(*tables_, image, features, scratch);
  } else {
    describe_upright(*tables_, image, features);
  }
}

}  // namespace pavo
#endif  // HWY_ONCE
