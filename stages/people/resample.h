// Weighted sums of neighbours, in rows of 13-bit pixels, in SIMD.
#pragma once

#include <cstddef>
#include <cstdint>

namespace pavo::hog {

/// out[x] = the rounded mean of pixels 2 x and 2 x + 1 of two rows, for x < n rounded up to the vector; twice as many
/// are read.
void halve_rows(const std::int16_t* above, const std::int16_t* below, int n, std::int16_t* out);

/// out[x] = the weighted sum of four rows, `stride` apart, weights in 1/2^14, for x < n rounded up to the vector.
void blend_rows(const std::int16_t* rows, std::size_t stride, const std::int16_t* weights, int n, std::int16_t* out);

/// out[i] = the weighted sum of the four pixels from offsets[i] on, rounded, for i < n rounded up to the vector.
/// The weights, in 1/2^14, are in pairs, the first of each in the low half.
void sample_row(const std::int16_t* row, const std::int32_t* offsets, const std::int32_t* weights01,
                const std::int32_t* weights23, int n, std::int16_t* out);

}  // namespace pavo::hog
