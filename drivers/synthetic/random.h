// Randomness that is a pure function of its seeds: the same street on every machine, thread and run.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

namespace pavo::synthetic {

/// A well mixing 32-bit hash (the "lowbias32" construction: xor-shifts and odd multiplications).
inline std::uint32_t hash(std::uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352dU;
  x ^= x >> 15;
  x *= 0x846ca68bU;
  return x ^ (x >> 16);
}
template <typename... Rest>
std::uint32_t hash(std::uint32_t a, std::uint32_t b, Rest... rest) {
  return hash(hash(a) + 0x9e3779b9U * (b + 1), rest...);
}

/// A stream of random numbers.
class Random {
 public:
  explicit Random(std::uint32_t seed) : state_(hash(seed)) {}
  std::uint32_t bits() { return hash(state_ += 0x9e3779b9U); }
  float unit() { return static_cast<float>(bits() >> 8) * 0x1p-24F; }  ///< [0, 1)
  float uniform(float low, float high) { return low + (high - low) * unit(); }
  int below(int n) {
    return static_cast<int>((static_cast<std::uint64_t>(bits()) * static_cast<std::uint64_t>(n)) >> 32);
  }
  bool chance(float p) { return unit() < p; }

 private:
  std::uint32_t state_;
};

/// Smooth noise in the plane, -1 to 1, with one random value per lattice point; it repeats after kSize cells.
class Noise {
 public:
  static constexpr int kSize = 512;

  explicit Noise(std::uint32_t seed) : lattice_(kSize * kSize) {
    Random random(seed);
    for (auto& value : lattice_) value = random.uniform(-1, 1);
  }
  float operator()(float x, float y) const {
    const float fx = std::floor(x), fy = std::floor(y);
    const int ix = static_cast<int>(fx), iy = static_cast<int>(fy);
    const float a = fade(x - fx), b = fade(y - fy);
    const float top = at(ix, iy) + a * (at(ix + 1, iy) - at(ix, iy));
    const float bottom = at(ix, iy + 1) + a * (at(ix + 1, iy + 1) - at(ix, iy + 1));
    return top + b * (bottom - top);
  }
  /// Several octaves, each half as large and `gain` times as strong as the one before.
  float fractal(float x, float y, int octaves, float gain = 0.5F) const {
    float sum = 0, strength = 1;
    for (int i = 0; i < octaves; ++i, strength *= gain) {
      sum += strength * (*this)(x, y);
      x = 2 * x + 17.3F;
      y = 2 * y + 71.9F;
    }
    return sum;
  }

 private:
  static float fade(float t) { return t * t * (3 - 2 * t); }
  float at(int x, int y) const {
    const int index = (y & (kSize - 1)) * kSize + (x & (kSize - 1));
    return lattice_[static_cast<std::size_t>(index)];
  }

  std::vector<float> lattice_;
};

}  // namespace pavo::synthetic
