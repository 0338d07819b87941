// The integer kernel of MatchNearest: descriptors in 16 bits, every dot product once, the best two of each row and of
// each column from it. Integers: the result does not depend on the SIMD target, and 16 x 16 -> 32 bit multiplies with
// pairwise addition do twice the work of a float multiply-add of the same width (but for AVX-512, where it is the
// same).
#pragma once

#include <cstddef>
#include <cstdint>

namespace pavo::nearest_kernel {

inline constexpr std::size_t kDepth = 64;  // elements of a descriptor
/// Arrays of columns have room for a multiple of this, whatever the SIMD target is.
inline constexpr std::size_t kColumnMultiple = 32;
/// Arrays of the rows' lanes have this many entries a row.
inline constexpr std::size_t kLanes = 16;
/// The largest length of a quantised descriptor: -|a - b|^2 / 2 of two stays above kNone.
inline constexpr float kLargestNorm = 23000;
/// A score below this is of nothing: there is no such row or column.
inline constexpr std::int32_t kNone = -1'200'000'000;

inline constexpr std::size_t padded(std::size_t n) {
  return (n + kColumnMultiple - 1) / kColumnMultiple * kColumnMultiple;
}

/// |d|^2 of a descriptor of 64 floats.
float norm2(const float* descriptor);

/// q = round(scale d), half_norm = |q|^2 / 2 rounded up. Returns |scale d - q|^2, what the rounding cost.
float quantise(const float* descriptor, float scale, std::int16_t* q, std::int32_t* half_norm);

/// Quantised descriptors: row i at 64 i, and |q|^2 / 2 of each.
struct Quantised {
  const std::int16_t* rows;
  const std::int32_t* half_norm;
  std::size_t size;
};

/// For each row or column: the best and the second best score. 64-byte aligned.
struct BestTwo {
  std::int32_t* score;
  std::int32_t* second;
};

/// Of rows also where the best is: in the columns column[i] + v lanes, v = 0 ... kVectors - 1, if there are so many.
struct RowBest : BestTwo {
  std::int32_t* column;
};
inline constexpr std::size_t kVectors = 2;

/// The columns as best_two_both_ways() wants them: 32 padded(b.size) and padded(b.size) entries.
struct Packed {
  std::int32_t* panels;
  std::int32_t* half_norm;
};
/// Returns the number of lanes, for RowBest::column.
std::size_t pack(const Quantised& b, const Packed& packed);

/// Scores of all pairs, a b - |a|^2 / 2 - |b|^2 / 2 = -|a - b|^2 / 2 (less 1 at most, by the rounding of the half
/// norms), and the best two of each row a and each column b. row_lanes is scratch: kLanes entries for each row. by_row:
/// a.size, by_column: padded(columns) entries. Rows may be taken in bands, each with a by_column of its own; merge()
/// makes one of them, and how the rows were divided makes no difference.
void best_two_both_ways(const Quantised& a, const Packed& b, std::size_t columns, const RowBest& row_lanes,
                        const RowBest& by_row, const BestTwo& by_column);
void merge(const BestTwo& band, std::size_t columns, const BestTwo& into);

/// The indices, ascending, of `others` whose score with descriptor `of` of `side` is at least `threshold`. Returns how
/// many.
std::size_t find_near(const Quantised& side, std::size_t of, const Quantised& others, std::int64_t threshold,
                      std::int32_t* found);

}  // namespace pavo::nearest_kernel
