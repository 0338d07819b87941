#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/decode/bayer.cpp"
#include <hwy/foreach_target.h>  // compiles this file once for each SIMD target
#include <hwy/highway.h>

#include <algorithm>

#include "stages/decode/formats.h"

// Luma of the bilinear interpolation, Y = 0.299 R + 0.587 G + 0.114 B, without making the colours first. What a pixel
// lacks is the mean of the neighbours that have it:
//
//   at red or blue:  own colour as it is;  green the mean of the 4 beside;  the other colour the mean of the 4 corners
//   at green:        as it is;  one colour the mean of left and right, the other that of above and below
//
// In sixty-fourths (19, 38, 7), so that sixteen times the sum of four neighbours fits into 16 bits.
HWY_BEFORE_NAMESPACE();
namespace pavo::decode_detail {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// One row, but for its first and last pixel. `row` has red (weight 19) or blue (7) beside the greens: `own`; `other`
/// is the weight of the colour in the rows above and below. `green_first`: pixel 0 is green.
void BayerRow(const std::uint8_t* HWY_RESTRICT above, const std::uint8_t* HWY_RESTRICT row,
              const std::uint8_t* HWY_RESTRICT below, int width, std::uint16_t own, std::uint16_t other,
              bool green_first, std::uint8_t* HWY_RESTRICT gray) {
  constexpr std::uint16_t kGreen = 38;
  const hn::CappedTag<std::uint16_t, 32> d16;
  const hn::Rebind<std::int16_t, decltype(d16)> di16;
  const hn::Rebind<std::uint8_t, decltype(d16)> d8;
  const auto n = static_cast<int>(hn::Lanes(d16));
  const auto at = [&](const std::uint8_t* p) HWY_ATTR { return hn::PromoteTo(d16, hn::LoadU(d8, p)); };
  const auto times = [&](auto v, std::uint16_t w) HWY_ATTR { return hn::Mul(v, hn::Set(d16, w)); };
  // Vectors start at odd pixels: their even lanes are green where the row starts with another colour.
  const auto odd_lane = hn::Ne(hn::And(hn::Iota(d16, 0), hn::Set(d16, 1)), hn::Zero(d16));
  const auto is_green = green_first ? odd_lane : hn::Not(odd_lane);
  const auto half = hn::Set(d16, 128);
  int x = 1;
  for (; x + n < width; x += n) {
    const auto centre = at(row + x);
    const auto across = hn::Add(at(row + x - 1), at(row + x + 1)), along = hn::Add(at(above + x), at(below + x));
    const auto corners =
        hn::Add(hn::Add(at(above + x - 1), at(above + x + 1)), hn::Add(at(below + x - 1), at(below + x + 1)));
    // Both in 1/256: at most 256 * 255 + 128.
    const auto coloured =
        hn::Add(hn::Add(times(centre, static_cast<std::uint16_t>(4 * own)), times(hn::Add(across, along), kGreen)),
                times(corners, other));
    const auto green = hn::Add(times(centre, 4 * kGreen), hn::Add(times(across, static_cast<std::uint16_t>(2 * own)),
                                                                  times(along, static_cast<std::uint16_t>(2 * other))));
    const auto luma = hn::ShiftRight<8>(hn::Add(hn::IfThenElse(is_green, green, coloured), half));
    hn::StoreU(hn::DemoteTo(d8, hn::BitCast(di16, luma)), d8, gray + x);
  }
  for (; x + 1 < width; ++x) {
    const int across = row[x - 1] + row[x + 1], along = above[x] + below[x];
    const int corners = above[x - 1] + above[x + 1] + below[x - 1] + below[x + 1];
    const bool is_green_here = (x % 2 == 0) == green_first;
    const int sum = is_green_here ? 4 * kGreen * row[x] + 2 * own * across + 2 * other * along
                                  : 4 * own * row[x] + kGreen * (across + along) + other * corners;
    gray[x] = static_cast<std::uint8_t>((sum + 128) >> 8);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace pavo::decode_detail
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pavo::decode_detail {

HWY_EXPORT(BayerRow);

namespace {

constexpr std::uint16_t kRed = 19, kBlue = 7;

// Mirrored at the border, so that every neighbour is of the colour that it has to be. One pixel is its own neighbour.
int mirrored(int i, int count) {
  if (i < 0) i = -i;
  if (i >= count) i = 2 * (count - 1) - i;
  return std::clamp(i, 0, count - 1);
}

/// The first and the last pixel of a row: the same, on three columns of their own.
void edge_pixel(const std::uint8_t* const rows[3], int x, int width, std::uint16_t own, std::uint16_t other,
                bool green_first, std::uint8_t* gray) {
  std::uint8_t part[3][3];
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) part[r][c] = rows[r][mirrored(x + c - 1, width)];
  std::uint8_t result[3] = {};
  // Pixel 1 of the part is pixel x of the row.
  const bool green_first_here = (x % 2 == 0) != green_first;
  HWY_STATIC_DISPATCH(BayerRow)(part[0], part[1], part[2], 3, own, other, green_first_here, result);
  gray[x] = result[1];
}

}  // namespace

bool is_bayer(Encoding encoding) {
  return encoding == Encoding::bayer_bggr8 || encoding == Encoding::bayer_gbrg8 || encoding == Encoding::bayer_grbg8 ||
         encoding == Encoding::bayer_rggb8;
}

void luma_of_bayer(const EncodedImage& frame, Image& out) {
  const bool green_first = frame.encoding == Encoding::bayer_gbrg8 || frame.encoding == Encoding::bayer_grbg8;
  const bool red_first = frame.encoding == Encoding::bayer_rggb8 || frame.encoding == Encoding::bayer_grbg8;
  for (int y = 0; y < frame.height; ++y) {
    const auto row = [&](int r) { return frame.bytes.data() + mirrored(r, frame.height) * frame.stride; };
    const std::uint8_t* const rows[3] = {row(y - 1), row(y), row(y + 1)};
    const bool even = y % 2 == 0, red = even == red_first, green = even == green_first;
    const std::uint16_t own = red ? kRed : kBlue, other = red ? kBlue : kRed;
    HWY_DYNAMIC_DISPATCH(BayerRow)(rows[0], rows[1], rows[2], frame.width, own, other, green, out.row(y));
    edge_pixel(rows, 0, frame.width, own, other, green, out.row(y));
    edge_pixel(rows, frame.width - 1, frame.width, own, other, green, out.row(y));
  }
}

}  // namespace pavo::decode_detail
#endif
