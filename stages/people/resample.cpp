#include "stages/people/resample.h"

#include <algorithm>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/people/resample.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pavo::hog {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// rounding + the sums of products of neighbours: lane i gets those of lanes 2 i and 2 i + 1 of the 16-bit vectors.
template <class V16, class V32>
HWY_INLINE V32 WeightedPairs(V16 a, V16 weights_a, V16 b, V16 weights_b, V32 rounding) {
  const hn::DFromV<V32> d;
#if HWY_ARCH_X86
  V32 unused = hn::Zero(d);
  const V32 sum = hn::ReorderWidenMulAccumulate(d, a, weights_a, rounding, unused);  // pmaddwd
  return hn::ReorderWidenMulAccumulate(d, b, weights_b, sum, unused);
#else
  const auto low = [&](V16 v) { return hn::ShiftRight<16>(hn::ShiftLeft<16>(hn::BitCast(d, v))); };
  const auto high = [&](V16 v) { return hn::ShiftRight<16>(hn::BitCast(d, v)); };
  V32 sum = hn::Add(rounding, hn::Mul(low(a), low(weights_a)));
  sum = hn::Add(sum, hn::Mul(high(a), high(weights_a)));
  sum = hn::Add(sum, hn::Mul(low(b), low(weights_b)));
  return hn::Add(sum, hn::Mul(high(b), high(weights_b)));
#endif
}

void BlendRows(const std::int16_t* HWY_RESTRICT rows, std::size_t stride, const std::int16_t* HWY_RESTRICT weights,
               int n, std::int16_t* HWY_RESTRICT out) {
  const hn::ScalableTag<std::int16_t> d;
  // The product is of numbers in 1/2^15, in which 1 is not to be had.
  const auto in_q15 = [d](std::int16_t q14) { return hn::Set(d, static_cast<std::int16_t>(std::min(2 * q14, 32767))); };
  const auto w0 = in_q15(weights[0]), w1 = in_q15(weights[1]), w2 = in_q15(weights[2]), w3 = in_q15(weights[3]);
  for (std::size_t x = 0; x < static_cast<std::size_t>(n); x += hn::Lanes(d)) {
    const auto p0 = hn::MulFixedPoint15(hn::LoadU(d, rows + x), w0);
    const auto p1 = hn::MulFixedPoint15(hn::LoadU(d, rows + stride + x), w1);
    const auto p2 = hn::MulFixedPoint15(hn::LoadU(d, rows + 2 * stride + x), w2);
    const auto p3 = hn::MulFixedPoint15(hn::LoadU(d, rows + 3 * stride + x), w3);
    hn::StoreU(hn::Add(hn::Add(p0, p1), hn::Add(p2, p3)), d, out + x);
  }
}

void HalveRows(const std::int16_t* HWY_RESTRICT above, const std::int16_t* HWY_RESTRICT below, int n,
               std::int16_t* HWY_RESTRICT out) {
  const hn::ScalableTag<std::int16_t> d;
  const auto rounding = hn::Set(d, 2);
  for (std::size_t x = 0; x < static_cast<std::size_t>(n); x += hn::Lanes(d)) {
    hn::Vec<decltype(d)> a0, a1, b0, b1;
    hn::LoadInterleaved2(d, above + 2 * x, a0, a1);
    hn::LoadInterleaved2(d, below + 2 * x, b0, b1);
    const auto sum = hn::Add(hn::Add(hn::Add(a0, a1), hn::Add(b0, b1)), rounding);
    hn::StoreU(hn::ShiftRight<2>(sum), d, out + x);
  }
}

void SampleRow(const std::int16_t* HWY_RESTRICT row, const std::int32_t* HWY_RESTRICT offsets,
               const std::int32_t* HWY_RESTRICT weights01, const std::int32_t* HWY_RESTRICT weights23, int n,
               std::int16_t* HWY_RESTRICT out) {
  // The pixels that a vector of results needs lie so close together that two loads have them: as pairs that begin at
  // even places and as pairs that begin at odd ones. A lookup picks each result's pairs; it is three times as fast as
  // gathers.
  const hn::CappedTag<std::int32_t, 16> d;
  const hn::Repartition<std::int16_t, decltype(d)> d16;
  const hn::Rebind<std::int16_t, decltype(d)> half;
  const auto rounding = hn::Set(d, 1 << 13), one = hn::Set(d, 1);
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int i = 0; i < n; i += lanes) {
    const std::int16_t* first = row + offsets[i];
    const auto even = hn::BitCast(d, hn::LoadU(d16, first)), odd = hn::BitCast(d, hn::LoadU(d16, first + 1));
    const auto place = hn::Sub(hn::LoadU(d, offsets + i), hn::Set(d, offsets[i]));
    const auto is_odd = hn::Eq(hn::And(place, one), one);
    const auto pair = hn::ShiftRight<1>(place);
    const auto pick = [&](auto index) HWY_ATTR {
      const auto indices = hn::IndicesFromVec(d, index);
      return hn::BitCast(
          d16, hn::IfThenElse(is_odd, hn::TableLookupLanes(odd, indices), hn::TableLookupLanes(even, indices)));
    };
    const auto pixels01 = pick(pair), pixels23 = pick(hn::Add(pair, one));
    const auto w01 = hn::BitCast(d16, hn::LoadU(d, weights01 + i)), w23 = hn::BitCast(d16, hn::LoadU(d, weights23 + i));
    const auto sum = WeightedPairs(pixels01, w01, pixels23, w23, rounding);
    hn::StoreU(hn::DemoteTo(half, hn::ShiftRight<14>(sum)), half, out + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace pavo::hog
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pavo::hog {

HWY_EXPORT(HalveRows);
HWY_EXPORT(BlendRows);
HWY_EXPORT(SampleRow);

void halve_rows(const std::int16_t* above, const std::int16_t* below, int n, std::int16_t* out) {
  HWY_DYNAMIC_DISPATCH(HalveRows)(above, below, n, out);
}

void blend_rows(const std::int16_t* rows, std::size_t stride, const std::int16_t* weights, int n, std::int16_t* out) {
  HWY_DYNAMIC_DISPATCH(BlendRows)(rows, stride, weights, n, out);
}

void sample_row(const std::int16_t* row, const std::int32_t* offsets, const std::int32_t* weights01,
                const std::int32_t* weights23, int n, std::int16_t* out) {
  HWY_DYNAMIC_DISPATCH(SampleRow)(row, offsets, weights01, weights23, n, out);
}

}  // namespace pavo::hog
#endif
