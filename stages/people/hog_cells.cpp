#include "stages/people/hog_cells.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/people/hog_cells.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pavo::hog {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D16 = hn::ScalableTag<std::int16_t>;
using D32 = hn::RepartitionToWide<D16>;
using V16 = hn::Vec<D16>;
using V32 = hn::Vec<D32>;

/// The votes of one vector of gradients, by orientation.
struct Votes {
  V16 v0, v1, v2, v3, v4, v5, v6, v7, v8;
};

/// C_k = u_k x g for the 9 directions at 20 k + 10 degrees. By the mirror symmetry of the directions, four products of
/// each coordinate serve for all of them: C_k = a_k - b_k and C_{8-k} = -(a_k + b_k).
HWY_INLINE Votes votes_of(V16 gx, V16 gy) {
  const D16 d;
  const V16 zero = hn::Zero(d);
  // Unsigned orientation: g and -g are the same. Turned up, only bins 0 and 8 still reach over the wrap.
  gx = hn::IfThenElse(hn::Lt(gy, zero), hn::Neg(gx), gx);
  gy = hn::Abs(gy);
  const auto q15 = [d](int value) { return hn::Set(d, static_cast<std::int16_t>(value)); };
  const V16 a0 = hn::MulFixedPoint15(gy, q15(32270)), b0 = hn::MulFixedPoint15(gx, q15(5690));   // 10 degrees
  const V16 a1 = hn::MulFixedPoint15(gy, q15(28378)), b1 = hn::MulFixedPoint15(gx, q15(16384));  // 30
  const V16 a2 = hn::MulFixedPoint15(gy, q15(21063)), b2 = hn::MulFixedPoint15(gx, q15(25102));  // 50
  const V16 a3 = hn::MulFixedPoint15(gy, q15(11207)), b3 = hn::MulFixedPoint15(gx, q15(30792));  // 70
  const V16 p0 = hn::Sub(a0, b0), q0 = hn::Add(a0, b0);
  const V16 p1 = hn::Sub(a1, b1), q1 = hn::Add(a1, b1);
  const V16 p2 = hn::Sub(a2, b2), q2 = hn::Add(a2, b2);
  const V16 p3 = hn::Sub(a3, b3), q3 = hn::Add(a3, b3);
  const auto tent = [zero](V16 x, V16 y) { return hn::Max(zero, hn::Min(x, y)); };
  Votes v;
  v.v0 = hn::Max(tent(q0, hn::Neg(p1)), hn::Min(hn::Neg(q0), p1));
  v.v1 = tent(p0, hn::Neg(p2));
  v.v2 = tent(p1, hn::Neg(p3));
  v.v3 = tent(p2, gx);
  v.v4 = tent(p3, q3);
  v.v5 = tent(hn::Neg(gx), q2);
  v.v6 = tent(hn::Neg(q3), q1);
  v.v7 = tent(hn::Neg(q2), q0);
  v.v8 = hn::Max(tent(hn::Neg(q1), p0), hn::Min(q1, hn::Neg(p0)));
  return v;
}

/// Sums of the products over each 8 lanes (one group), spread over the 4 numbers of its 128-bit block in some order.
HWY_INLINE V32 partial(V16 values, V16 weights) {
  V32 other = hn::Zero(D32());
  const V32 first = hn::ReorderWidenMulAccumulate(D32(), values, weights, hn::Zero(D32()), other);
  return hn::Add(first, other);
}

/// Lane i of each 128-bit block: the sum of that block of q_i.
HWY_INLINE V32 sums_of_blocks(V32 q0, V32 q1, V32 q2, V32 q3) {
  const D32 d;
  const hn::RepartitionToWide<D32> d64;
  const V32 t0 = hn::Add(hn::InterleaveLower(d, q0, q1), hn::InterleaveUpper(d, q0, q1));
  const V32 t1 = hn::Add(hn::InterleaveLower(d, q2, q3), hn::InterleaveUpper(d, q2, q3));
  const auto w0 = hn::BitCast(d64, t0), w1 = hn::BitCast(d64, t1);
  return hn::Add(hn::BitCast(d, hn::InterleaveLower(d64, w0, w1)), hn::BitCast(d, hn::InterleaveUpper(d64, w0, w1)));
}

void VoteBand(const std::int16_t* const* rows, int groups, const BandSums& sums) {
  const D16 d;
  alignas(16) static constexpr std::int16_t kRight[8] = {1, 3, 5, 7, 9, 11, 13, 15};
  alignas(16) static constexpr std::int16_t kLeft[8] = {15, 13, 11, 9, 7, 5, 3, 1};
  const V16 right = hn::LoadDup128(d, kRight), left = hn::LoadDup128(d, kLeft);
  const int lanes = static_cast<int>(hn::Lanes(d));

  for (int x = 0; x < 8 * groups; x += lanes) {
    const V16 zero = hn::Zero(d);
    V16 s0 = zero, s1 = zero, s2 = zero, s3 = zero, s4 = zero, s5 = zero, s6 = zero, s7 = zero, s8 = zero;
    V16 l0 = zero, l1 = zero, l2 = zero, l3 = zero, l4 = zero, l5 = zero, l6 = zero, l7 = zero, l8 = zero;
    for (int y = 0; y < kCell; ++y) {
      const std::int16_t* row = rows[y + 1] + x;
      const V16 gx = hn::Sub(hn::LoadU(d, row + 1), hn::LoadU(d, row - 1));
      const V16 gy = hn::Sub(hn::LoadU(d, rows[y + 2] + x), hn::LoadU(d, rows[y] + x));
      const Votes v = votes_of(gx, gy);
      const V16 below = hn::Set(d, static_cast<std::int16_t>((2 * y + 1) * 2048));  // (y + 1/2) / 8
      s0 = hn::Add(s0, v.v0), l0 = hn::Add(l0, hn::MulFixedPoint15(v.v0, below));
      s1 = hn::Add(s1, v.v1), l1 = hn::Add(l1, hn::MulFixedPoint15(v.v1, below));
      s2 = hn::Add(s2, v.v2), l2 = hn::Add(l2, hn::MulFixedPoint15(v.v2, below));
      s3 = hn::Add(s3, v.v3), l3 = hn::Add(l3, hn::MulFixedPoint15(v.v3, below));
      s4 = hn::Add(s4, v.v4), l4 = hn::Add(l4, hn::MulFixedPoint15(v.v4, below));
      s5 = hn::Add(s5, v.v5), l5 = hn::Add(l5, hn::MulFixedPoint15(v.v5, below));
      s6 = hn::Add(s6, v.v6), l6 = hn::Add(l6, hn::MulFixedPoint15(v.v6, below));
      s7 = hn::Add(s7, v.v7), l7 = hn::Add(l7, hn::MulFixedPoint15(v.v7, below));
      s8 = hn::Add(s8, v.v8), l8 = hn::Add(l8, hn::MulFixedPoint15(v.v8, below));
    }
    std::int32_t* to = sums.data + x / 2;
    const auto store = [&](int bin, V16 all, V16 low) {
      const V16 up = hn::Sub(all, low);
      hn::StoreU(sums_of_blocks(partial(up, left), partial(up, right), partial(low, left), partial(low, right)), D32(),
                 to + static_cast<std::size_t>(bin) * sums.plane);
    };
    store(0, s0, l0), store(1, s1, l1), store(2, s2, l2), store(3, s3, l3), store(4, s4, l4);
    store(5, s5, l5), store(6, s6, l6), store(7, s7, l7), store(8, s8, l8);
  }
}

void GatherCells(const BandSums& sums, int cells_x, std::size_t stride, std::int32_t* carry, float* cells,
                 float* energy) {
  const D32 d;
  const hn::RebindToFloat<D32> df;
  const std::size_t lanes = hn::Lanes(d);
  for (std::size_t c = 0; c < static_cast<std::size_t>(cells_x); c += lanes) {
    auto squares = hn::Zero(df);
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      // Cell c lies right of group c and left of group c + 1.
      const std::int32_t* group = sums.data + bin * sums.plane + 4 * c;
      V32 above_left, above_right, below_left, below_right, unused;
      hn::LoadInterleaved4(d, group, unused, above_right, unused, below_right);
      hn::LoadInterleaved4(d, group + 4, above_left, unused, below_left, unused);
      std::int32_t* carried = carry + bin * stride + c;
      const auto cell = hn::ConvertTo(df, hn::Add(hn::LoadU(d, carried), hn::Add(above_left, above_right)));
      hn::StoreU(hn::Add(below_left, below_right), d, carried);
      hn::StoreU(cell, df, cells + bin * stride + c);
      squares = hn::MulAdd(cell, cell, squares);
    }
    hn::StoreU(squares, df, energy + c);
  }
}

void NormaliseBlocks(const float* upper, const float* upper_energy, const float* lower, const float* lower_energy,
                     std::size_t columns, std::size_t stride, float epsilon, float clip, float fade, float* blocks) {
  const hn::ScalableTag<float> d;
  const auto one = hn::Set(d, 1.0f), eps = hn::Set(d, epsilon), largest = hn::Set(d, clip);
  for (std::size_t c = 0; c < columns; c += hn::Lanes(d)) {
    const auto energy = hn::Add(hn::Add(hn::LoadU(d, upper_energy + c), hn::LoadU(d, upper_energy + c + 1)),
                                hn::Add(hn::LoadU(d, lower_energy + c), hn::LoadU(d, lower_energy + c + 1)));
    const auto scale = hn::Div(one, hn::Add(hn::Sqrt(energy), eps));
    auto squares = hn::Zero(d);
    const auto clipped = [&](const float* cells, std::size_t bin, std::size_t cell_x) {
      return hn::Min(largest, hn::Mul(scale, hn::LoadU(d, cells + bin * stride + c + cell_x)));
    };
    for (std::size_t cell = 0; cell < 4; ++cell)
      for (std::size_t bin = 0; bin < kBins; ++bin) {
        const auto value = clipped(cell < 2 ? upper : lower, bin, cell % 2);
        squares = hn::MulAdd(value, value, squares);
        hn::StoreU(value, d, blocks + (cell * kBins + bin) * stride + c);
      }
    const auto again = hn::Div(one, hn::Add(hn::Sqrt(squares), hn::Set(d, fade)));
    for (std::size_t f = 0; f < kBlockSize; ++f) {
      float* value = blocks + f * stride + c;
      hn::StoreU(hn::Mul(again, hn::LoadU(d, value)), d, value);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace pavo::hog
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pavo::hog {

HWY_EXPORT(VoteBand);
HWY_EXPORT(GatherCells);
HWY_EXPORT(NormaliseBlocks);

void vote_band(const std::int16_t* const* rows, int groups, const BandSums& sums) {
  HWY_DYNAMIC_DISPATCH(VoteBand)(rows, groups, sums);
}

void gather_cells(const BandSums& sums, int cells_x, std::size_t stride, std::int32_t* carry, float* cells,
                  float* energy) {
  HWY_DYNAMIC_DISPATCH(GatherCells)(sums, cells_x, stride, carry, cells, energy);
}

void normalise_blocks(const float* upper, const float* upper_energy, const float* lower, const float* lower_energy,
                      std::size_t columns, std::size_t stride, float epsilon, float clip, float fade, float* blocks) {
  HWY_DYNAMIC_DISPATCH(NormaliseBlocks)
  (upper, upper_energy, lower, lower_energy, columns, stride, epsilon, clip, fade, blocks);
}

}  // namespace pavo::hog
#endif
