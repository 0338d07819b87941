#include "stages/matches/nearest_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/matches/nearest_kernel.cpp"
#include <hwy/foreach_target.h>  // compiles this file once for each SIMD target
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace pavo::nearest_kernel {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kPairs = kDepth / 2;  // elements go in pairs, which fill 32 bits
constexpr std::size_t kRows = 4;  // of the register block: 8 sums, 2 columns, rows and products fit in 16 registers
constexpr std::int32_t kPaddingHalfNorm = 1'600'000'000;  // its score is below kNone, and no overflow
constexpr std::int32_t kNever = std::numeric_limits<std::int32_t>::min();

using DF = hn::CappedTag<float, kLanes>;
using DI = hn::RebindToSigned<DF>;
using D16 = hn::Repartition<std::int16_t, DI>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;

/// sum + the products of the two 16-bit elements of each lane.
HWY_INLINE VI AddProducts(VI a, VI b, VI sum) {
#if HWY_ARCH_X86
  VI unused = sum;
  return hn::ReorderWidenMulAccumulate(DI(), hn::BitCast(D16(), a), hn::BitCast(D16(), b), sum, unused);
#else  // where that instruction adds other pairs
  const VI low = hn::Mul(hn::ShiftRight<16>(hn::ShiftLeft<16>(a)), hn::ShiftRight<16>(hn::ShiftLeft<16>(b)));
  return hn::Add(sum, hn::Add(low, hn::Mul(hn::ShiftRight<16>(a), hn::ShiftRight<16>(b))));
#endif
}

HWY_INLINE VI LoadPairs(const std::int16_t* HWY_RESTRICT p) {
  return hn::BitCast(DI(), hn::LoadU(D16(), p));
}

float Norm2(const float* HWY_RESTRICT d) {
  const DF df;
  VF sum = hn::Zero(df);
  for (std::size_t k = 0; k < kDepth; k += hn::Lanes(df)) {
    const VF v = hn::LoadU(df, d + k);
    sum = hn::MulAdd(v, v, sum);
  }
  return hn::GetLane(hn::SumOfLanes(df, sum));
}

float Quantise(const float* HWY_RESTRICT d, float scale, std::int16_t* HWY_RESTRICT q, std::int32_t* half_norm) {
  const DF df;
  const DI di;
  const hn::Rebind<std::int16_t, DF> d16;
  const VF s = hn::Set(df, scale);
  VF cost = hn::Zero(df);
  VI norm2 = hn::Zero(di);
  for (std::size_t k = 0; k < kDepth; k += hn::Lanes(df)) {
    const VF scaled = hn::Mul(hn::LoadU(df, d + k), s);
    const VI rounded = hn::NearestInt(scaled);
    const VF rest = hn::Sub(scaled, hn::ConvertTo(df, rounded));
    cost = hn::MulAdd(rest, rest, cost);
    norm2 = hn::Add(norm2, hn::Mul(rounded, rounded));
    hn::StoreU(hn::DemoteTo(d16, rounded), d16, q + k);
  }
  *half_norm = (hn::GetLane(hn::SumOfLanes(di, norm2)) + 1) / 2;
  return hn::GetLane(hn::SumOfLanes(df, cost));
}

/// Panel p holds, for each pair of elements, the pairs of the columns [p width, (p + 1) width).
std::size_t Pack(const Quantised& b, std::int32_t* HWY_RESTRICT panels, std::int32_t* HWY_RESTRICT half_norm) {
  const std::size_t lanes = hn::Lanes(DI()), width = kVectors * lanes;
  for (std::size_t first = 0; first < b.size; first += width) {
    std::int32_t* panel = panels + first * kPairs;
    const std::size_t n = std::min(width, b.size - first);
    if (n < width) std::fill_n(panel, kPairs * width, 0);
    for (std::size_t c = 0; c < n; ++c)
      for (std::size_t k = 0; k < kPairs; ++k)
        std::memcpy(panel + k * width + c, b.rows + (first + c) * kDepth + 2 * k, sizeof(std::int32_t));
    std::copy_n(b.half_norm + first, n, half_norm + first);
    std::fill(half_norm + first + n, half_norm + first + width, kPaddingHalfNorm);
  }
  return lanes;
}

/// The best two so far of one vector of columns.
struct Tracker {
  VI score, second;
  HWY_INLINE void See(VI s) {
    second = hn::Max(second, hn::Min(s, score));
    score = hn::Max(score, s);
  }
};

/// One row against two vectors of columns. Which of them was better is not kept: there are only two to look at later.
HWY_INLINE void SeeRow(VI s0, VI s1, std::size_t row, VI column, const RowBest& lanes) {
  const DI di;
  const std::size_t at = row * hn::Lanes(di);
  const VI score = hn::Load(di, lanes.score + at), second = hn::Load(di, lanes.second + at);
  const VI top = hn::Max(s0, s1), low = hn::Min(s0, s1);
  const auto better = hn::Gt(top, score);
  hn::Store(hn::Max(hn::Max(second, low), hn::Min(score, top)), di, lanes.second + at);
  hn::Store(hn::Max(score, top), di, lanes.score + at);
  hn::Store(hn::IfThenElse(better, column, hn::Load(di, lanes.column + at)), di, lanes.column + at);
}

/// Four rows against one panel, which stays in the first cache.
HWY_INLINE void Block(const Quantised& a, std::size_t first_row, const std::int32_t* HWY_RESTRICT panel, VI h0, VI h1,
                      VI column, const RowBest& row_lanes, Tracker& c0, Tracker& c1) {
  const DI di;
  const std::size_t n = hn::Lanes(di);
  const std::size_t last = a.size - 1;
  const auto row = [&](std::size_t i) HWY_ATTR { return a.rows + std::min(first_row + i, last) * kDepth; };
  const auto pair = [](const std::int16_t* r, std::size_t k) HWY_ATTR {
    std::int32_t both;
    std::memcpy(&both, r + 2 * k, sizeof(both));
    return hn::Set(DI(), both);
  };
  const auto minus_half_norm = [&](std::size_t i)
                                   HWY_ATTR { return hn::Set(di, -a.half_norm[std::min(first_row + i, last)]); };
  const std::int16_t *r0 = row(0), *r1 = row(1), *r2 = row(2), *r3 = row(3);
  VI s00 = hn::Sub(minus_half_norm(0), h0), s01 = hn::Sub(minus_half_norm(0), h1);
  VI s10 = hn::Sub(minus_half_norm(1), h0), s11 = hn::Sub(minus_half_norm(1), h1);
  VI s20 = hn::Sub(minus_half_norm(2), h0), s21 = hn::Sub(minus_half_norm(2), h1);
  VI s30 = hn::Sub(minus_half_norm(3), h0), s31 = hn::Sub(minus_half_norm(3), h1);
  const auto step = [&](std::size_t k) HWY_ATTR {
    const VI b0 = hn::Load(di, panel), b1 = hn::Load(di, panel + n);
    panel += kVectors * n;
    const VI x0 = pair(r0, k), x1 = pair(r1, k), x2 = pair(r2, k), x3 = pair(r3, k);
    s00 = AddProducts(x0, b0, s00), s01 = AddProducts(x0, b1, s01);
    s10 = AddProducts(x1, b0, s10), s11 = AddProducts(x1, b1, s11);
    s20 = AddProducts(x2, b0, s20), s21 = AddProducts(x2, b1, s21);
    s30 = AddProducts(x3, b0, s30), s31 = AddProducts(x3, b1, s31);
  };
  for (std::size_t k = 0; k < kPairs; ++k) step(k);
  const auto see = [&](std::size_t i, VI s0, VI s1) HWY_ATTR {
    if (first_row + i > last) return;
    SeeRow(s0, s1, first_row + i, column, row_lanes);
    c0.See(s0);
    c1.See(s1);
  };
  see(0, s00, s01), see(1, s10, s11), see(2, s20, s21), see(3, s30, s31);
}

/// The lanes of a row hold the best two of every Lanes()-th column: together they give the row's.
void ReduceLanes(const RowBest& lanes, std::size_t rows, const RowBest& by_row) {
  const DI di;
  const std::size_t n = hn::Lanes(di);
  for (std::size_t r = 0; r < rows; ++r) {
    const std::size_t at = r * n;
    const VI score = hn::Load(di, lanes.score + at);
    const VI best = hn::MaxOfLanes(di, score);
    const auto is_best = hn::Eq(score, best);
    const auto winner = static_cast<std::size_t>(hn::FindFirstTrue(di, is_best));
    // All lanes but the winner offer their best, the winner its second best.
    const auto is_winner = hn::Eq(hn::Iota(di, 0), hn::Set(di, static_cast<std::int32_t>(winner)));
    const VI second = hn::MaxOfLanes(di, hn::IfThenElse(is_winner, hn::Load(di, lanes.second + at), score));
    by_row.score[r] = hn::GetLane(best);
    by_row.second[r] = hn::GetLane(second);
    by_row.column[r] = lanes.column[at + winner] + static_cast<std::int32_t>(winner);
  }
}

void BestTwoBothWays(const Quantised& a, const Packed& b, std::size_t columns, const RowBest& row_lanes,
                     const RowBest& by_row, const BestTwo& by_column) {
  const DI di;
  const std::size_t n = hn::Lanes(di), width = kVectors * n;
  std::fill_n(row_lanes.score, a.size * n, kNever);
  std::fill_n(row_lanes.second, a.size * n, kNever);
  std::fill_n(row_lanes.column, a.size * n, 0);
  for (std::size_t first = 0; first < columns; first += width) {
    const VI column = hn::Set(di, static_cast<std::int32_t>(first));
    const VI h0 = hn::Load(di, b.half_norm + first), h1 = hn::Load(di, b.half_norm + first + n);
    const VI never = hn::Set(di, kNever);
    Tracker c0{never, never}, c1{never, never};
    for (std::size_t r = 0; r < a.size; r += kRows)
      Block(a, r, b.panels + first * kPairs, h0, h1, column, row_lanes, c0, c1);
    hn::Store(c0.score, di, by_column.score + first), hn::Store(c0.second, di, by_column.second + first);
    hn::Store(c1.score, di, by_column.score + first + n), hn::Store(c1.second, di, by_column.second + first + n);
  }
  ReduceLanes(row_lanes, a.size, by_row);
}

void Merge(const BestTwo& band, std::size_t columns, const BestTwo& into) {
  const DI di;
  for (std::size_t c = 0; c < columns; c += hn::Lanes(di)) {  // arrays are padded
    const VI score = hn::Load(di, into.score + c), other = hn::Load(di, band.score + c);
    const VI second = hn::Max(hn::Load(di, into.second + c), hn::Load(di, band.second + c));
    hn::Store(hn::Max(second, hn::Min(score, other)), di, into.second + c);
    hn::Store(hn::Max(score, other), di, into.score + c);
  }
}

std::size_t FindNear(const Quantised& side, std::size_t of, const Quantised& others, std::int64_t threshold,
                     std::int32_t* HWY_RESTRICT found) {
  const DI di;
  const std::size_t step = hn::Lanes(D16());
  const std::int16_t* HWY_RESTRICT a = side.rows + of * kDepth;
  std::size_t count = 0;
  for (std::size_t j = 0; j < others.size; ++j) {
    const std::int16_t* HWY_RESTRICT b = others.rows + j * kDepth;
    VI sum = hn::Zero(di);
    for (std::size_t k = 0; k < kDepth; k += step) sum = AddProducts(LoadPairs(a + k), LoadPairs(b + k), sum);
    const std::int64_t dot = hn::GetLane(hn::SumOfLanes(di, sum));
    found[count] = static_cast<std::int32_t>(j);
    count += dot - side.half_norm[of] - others.half_norm[j] >= threshold;
  }
  return count;
}

}  // namespace HWY_NAMESPACE
}  // namespace pavo::nearest_kernel
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pavo::nearest_kernel {

HWY_EXPORT(Norm2);
HWY_EXPORT(Quantise);
HWY_EXPORT(Pack);
HWY_EXPORT(BestTwoBothWays);
HWY_EXPORT(Merge);
HWY_EXPORT(FindNear);

float norm2(const float* descriptor) {
  return HWY_DYNAMIC_DISPATCH(Norm2)(descriptor);
}

float quantise(const float* descriptor, float scale, std::int16_t* q, std::int32_t* half_norm) {
  return HWY_DYNAMIC_DISPATCH(Quantise)(descriptor, scale, q, half_norm);
}

std::size_t pack(const Quantised& b, const Packed& packed) {
  return HWY_DYNAMIC_DISPATCH(Pack)(b, packed.panels, packed.half_norm);
}

void best_two_both_ways(const Quantised& a, const Packed& b, std::size_t columns, const RowBest& row_lanes,
                        const RowBest& by_row, const BestTwo& by_column) {
  HWY_DYNAMIC_DISPATCH(BestTwoBothWays)(a, b, columns, row_lanes, by_row, by_column);
}

void merge(const BestTwo& band, std::size_t columns, const BestTwo& into) {
  HWY_DYNAMIC_DISPATCH(Merge)(band, columns, into);
}

std::size_t find_near(const Quantised& side, std::size_t of, const Quantised& others, std::int64_t threshold,
                      std::int32_t* found) {
  return HWY_DYNAMIC_DISPATCH(FindNear)(side, of, others, threshold, found);
}

}  // namespace pavo::nearest_kernel
#endif
