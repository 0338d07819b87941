// The inner loop of Undistort.
#pragma once

#include <cstddef>
#include <cstdint>

namespace pavo::undistort_detail {

inline constexpr int kWeightBits = 7;  // positions in 1/128 pixel: products fit 16 bits

/// One output row of `width` pixels: from `source` (its first pixel), `offset` and `weight` as Undistort keeps them,
/// `valid` 255 or 0. All but `source` are 64-byte aligned, and readable and writable up to the next multiple of 64
/// pixels. Up to 2 bytes behind the four source pixels are read.
void remap_row(const std::uint8_t* source, std::ptrdiff_t source_stride, const std::int32_t* offset,
               const std::uint16_t* weight, const std::uint8_t* valid, int width, std::uint8_t* out);

}  // namespace pavo::undistort_detail
