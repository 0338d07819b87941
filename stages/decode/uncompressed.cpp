#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/decode/uncompressed.cpp"
#include <hwy/foreach_target.h>  // compiles this file once for each SIMD target
#include <hwy/highway.h>

#include <cstring>
#include <stdexcept>
#include <string>

#include "stages/decode/formats.h"

HWY_BEFORE_NAMESPACE();
namespace pavo::decode_detail {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The luma of pixels of two bytes: the lower one (YUYV) or the upper one (UYVY, and 16-bit gray's upper half).
template <bool kUpper>
void EveryOtherByte(const std::uint8_t* HWY_RESTRICT pairs, int width, std::uint8_t* HWY_RESTRICT gray) {
  const hn::CappedTag<std::uint8_t, 64> d8;
  const auto n = static_cast<int>(hn::Lanes(d8));
  const auto every_other = [&](const std::uint8_t* from) HWY_ATTR {
    const auto low = hn::LoadU(d8, from), high = hn::LoadU(d8, from + n);
    return kUpper ? hn::ConcatOdd(d8, high, low) : hn::ConcatEven(d8, high, low);
  };
  int x = 0;
  for (; x + 2 * n <= width; x += 2 * n) {
    const auto a = every_other(pairs + 2 * x), b = every_other(pairs + 2 * (x + n));
    hn::StoreU(a, d8, gray + x);
    hn::StoreU(b, d8, gray + x + n);
  }
  for (; x + n <= width; x += n) hn::StoreU(every_other(pairs + 2 * x), d8, gray + x);
  for (; x < width; ++x) gray[x] = pairs[2 * x + (kUpper ? 1 : 0)];
}

void LowerBytes(const std::uint8_t* HWY_RESTRICT pairs, int width, std::uint8_t* HWY_RESTRICT gray) {
  EveryOtherByte<false>(pairs, width, gray);
}
void UpperBytes(const std::uint8_t* HWY_RESTRICT pairs, int width, std::uint8_t* HWY_RESTRICT gray) {
  EveryOtherByte<true>(pairs, width, gray);
}

/// first, green, last: the weights of the three channels in their order in memory; they add up to 256.
void Luma(const std::uint8_t* HWY_RESTRICT colour, int width, std::uint16_t first, std::uint16_t last,
          std::uint8_t* HWY_RESTRICT gray) {
  constexpr std::uint16_t kGreen = 150;
  const hn::CappedTag<std::uint8_t, 64> d8;
  const hn::Half<decltype(d8)> dh;
  const hn::Rebind<std::uint16_t, decltype(dh)> d16;
  const auto wa = hn::Set(d16, first), wg = hn::Set(d16, kGreen), wb = hn::Set(d16, last), half = hn::Set(d16, 128);
  const auto n = static_cast<int>(hn::Lanes(d8));
  const auto luma = [&](auto a, auto g, auto b) HWY_ATTR {  // at most 255 * 256 + 128
    const auto sum = hn::Add(hn::Mul(hn::PromoteTo(d16, a), wa), hn::Mul(hn::PromoteTo(d16, g), wg));
    return hn::ShiftRight<8>(hn::Add(hn::Add(sum, hn::Mul(hn::PromoteTo(d16, b), wb)), half));
  };
  const hn::Rebind<std::int16_t, decltype(dh)> di16;
  int x = 0;
  for (; x + n <= width; x += n) {
    auto a = hn::Zero(d8), g = a, b = a;
    hn::LoadInterleaved3(d8, colour + 3 * x, a, g, b);
    const auto low = luma(hn::LowerHalf(dh, a), hn::LowerHalf(dh, g), hn::LowerHalf(dh, b));
    const auto high = luma(hn::UpperHalf(dh, a), hn::UpperHalf(dh, g), hn::UpperHalf(dh, b));
    hn::StoreU(hn::DemoteTo(dh, hn::BitCast(di16, low)), dh, gray + x);
    hn::StoreU(hn::DemoteTo(dh, hn::BitCast(di16, high)), dh, gray + x + n / 2);
  }
  for (; x < width; ++x)
    gray[x] = static_cast<std::uint8_t>(
        (colour[3 * x] * first + colour[3 * x + 1] * kGreen + colour[3 * x + 2] * last + 128) >> 8);
}

}  // namespace HWY_NAMESPACE
}  // namespace pavo::decode_detail
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pavo::decode_detail {

HWY_EXPORT(Luma);
HWY_EXPORT(LowerBytes);
HWY_EXPORT(UpperBytes);

void luma_of_bgr(const std::uint8_t* bgr, int width, std::uint8_t* gray) {
  HWY_DYNAMIC_DISPATCH(Luma)(bgr, width, 29, 77, gray);
}

void luma_of_rgb(const std::uint8_t* rgb, int width, std::uint8_t* gray) {
  HWY_DYNAMIC_DISPATCH(Luma)(rgb, width, 77, 29, gray);
}

namespace {

std::int64_t bytes_a_pixel(Encoding encoding) {
  switch (encoding) {
    case Encoding::bgr24:
    case Encoding::rgb24:
      return 3;
    case Encoding::yuyv:
    case Encoding::uyvy:
    case Encoding::gray16:
      return 2;
    default:
      return 1;
  }
}

void luma_of_row(Encoding encoding, const std::uint8_t* row, int width, std::uint8_t* gray) {
  switch (encoding) {
    case Encoding::bgr24:
      return luma_of_bgr(row, width, gray);
    case Encoding::rgb24:
      return luma_of_rgb(row, width, gray);
    case Encoding::yuyv:
      return HWY_DYNAMIC_DISPATCH(LowerBytes)(row, width, gray);
    case Encoding::uyvy:
    case Encoding::gray16:
      return HWY_DYNAMIC_DISPATCH(UpperBytes)(row, width, gray);
    default:
      std::memcpy(gray, row, static_cast<std::size_t>(width));
  }
}

void check_bytes(const EncodedImage& frame) {
  const std::int64_t row_bytes = frame.width * bytes_a_pixel(frame.encoding);
  if (frame.stride < row_bytes)
    throw std::runtime_error("the frame's rows are " + std::to_string(frame.stride) +
                             " bytes apart; expected at least " + std::to_string(row_bytes));
  const auto size = static_cast<std::int64_t>(frame.bytes.size());
  if (size < row_bytes || (size - row_bytes) / frame.stride < frame.height - 1)
    throw std::runtime_error("the frame has " + std::to_string(size) + " bytes, too few for " +
                             std::to_string(frame.height) + " rows of " + std::to_string(frame.stride));
}

}  // namespace

void decode_uncompressed(const EncodedImage& frame, const SizeCheck& check_size, Image& out) {
  check_size(frame.width, frame.height);
  check_bytes(frame);
  out.resize(frame.width, frame.height);
  if (is_bayer(frame.encoding)) return luma_of_bayer(frame, out);
  if (frame.encoding == Encoding::gray8 && frame.stride == out.stride()) {  // nothing between the rows: one copy
    const std::ptrdiff_t all = frame.stride * (frame.height - 1) + frame.width;
    std::memcpy(out.row(0), frame.bytes.data(), static_cast<std::size_t>(all));
    return;
  }
  for (int y = 0; y < frame.height; ++y)
    luma_of_row(frame.encoding, frame.bytes.data() + y * frame.stride, frame.width, out.row(y));
}

}  // namespace pavo::decode_detail
#endif
