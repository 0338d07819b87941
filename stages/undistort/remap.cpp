#include "stages/undistort/remap.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/undistort/remap.cpp"
#include <hwy/foreach_target.h>  // compiles this file once for each SIMD target
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace pavo::undistort_detail {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Each 32-bit lane is one pixel, and its two halves are the upper and the lower source row: so horizontal
/// interpolation does both rows at once, in 16 bits, and the vertical one is the same between the halves.
void RemapRow(const std::uint8_t* HWY_RESTRICT source, std::ptrdiff_t source_stride,
              const std::int32_t* HWY_RESTRICT offset, const std::uint16_t* HWY_RESTRICT weight,
              const std::uint8_t* HWY_RESTRICT valid, int width, std::uint8_t* HWY_RESTRICT out) {
  const hn::CappedTag<std::int32_t, 16> d32;
  const hn::RebindToUnsigned<decltype(d32)> du32;
  const hn::Repartition<std::int16_t, decltype(d32)> d16;
  const hn::Repartition<std::uint16_t, decltype(d32)> du16;
  const hn::Rebind<std::uint16_t, decltype(d32)> dw;
  const hn::Rebind<std::uint8_t, decltype(d32)> d8;
  const auto* upper = reinterpret_cast<const std::int32_t*>(source);
  const auto* lower = reinterpret_cast<const std::int32_t*>(source + source_stride);
  const auto low_byte = hn::Set(d32, 0xFF), high_half = hn::Set(d32, 0xFF0000), second_byte = hn::Set(d32, 0xFF00);
  const auto half = hn::Set(du16, 64);

  const auto n = static_cast<int>(hn::Lanes(d32));
  for (int x = 0; x < width; x += n) {
    const auto at = hn::Load(d32, offset + x);
    const auto u = hn::GatherOffset(d32, upper, at);  // 4 bytes: the two pixels and two that nobody looks at
    const auto l = hn::GatherOffset(d32, lower, at);
    const auto left = hn::Or(hn::And(u, low_byte), hn::And(hn::ShiftLeft<16>(l), high_half));
    const auto right = hn::Or(hn::And(hn::ShiftRight<8>(u), low_byte), hn::ShiftLeft<8>(hn::And(l, second_byte)));
    const auto w = hn::PromoteTo(d32, hn::Load(dw, weight + x));
    const auto wx = hn::And(w, low_byte);
    const auto wx2 = hn::BitCast(d16, hn::Or(wx, hn::ShiftLeft<16>(wx)));
    const auto left16 = hn::BitCast(d16, left), right16 = hn::BitCast(d16, right);
    // 15 bits: 128 left + wx (right - left), at most 255 * 128
    const auto rows = hn::Add(hn::ShiftLeft<kWeightBits>(left16), hn::Mul(hn::Sub(right16, left16), wx2));
    const auto lower_row = hn::BitCast(d16, hn::ShiftRight<16>(hn::BitCast(du32, rows)));
    // MulFixedPoint15 divides by 2^15: the weight, 0 to 127 in the high byte, is wy / 128 there
    const auto wy = hn::BitCast(d16, hn::And(w, second_byte));
    const auto value = hn::Add(rows, hn::MulFixedPoint15(hn::Sub(lower_row, rows), wy));
    const auto rounded = hn::ShiftRight<kWeightBits>(hn::Add(hn::BitCast(du16, value), half));
    const auto pixel = hn::And(hn::BitCast(d32, rounded), low_byte);
    hn::Store(hn::And(hn::DemoteTo(d8, pixel), hn::Load(d8, valid + x)), d8, out + x);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace pavo::undistort_detail
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pavo::undistort_detail {

HWY_EXPORT(RemapRow);

void remap_row(const std::uint8_t* source, std::ptrdiff_t source_stride, const std::int32_t* offset,
               const std::uint16_t* weight, const std::uint8_t* valid, int width, std::uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(RemapRow)(source, source_stride, offset, weight, valid, width, out);
}

}  // namespace pavo::undistort_detail
#endif
