#include "stages/features/surf_orientation.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "stages/features/surf_tables.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/features/surf_orientation.cpp"
#include <hwy/foreach_target.h>  // compiles the part below once for every SIMD target
#include <hwy/highway.h>

#ifndef PAVO_STAGES_FEATURES_SURF_ORIENTATION_ONCE
#define PAVO_STAGES_FEATURES_SURF_ORIENTATION_ONCE
namespace pavo {

/// The weighted gradients of one keypoint; `packed` holds both parts, x in the upper 32 bits, so that one sum adds
/// both.
struct Gradients {
  static constexpr int kCapacity = 128;  // 113 lie in the circle; room for a whole vector
  alignas(64) std::int32_t x[kCapacity];
  alignas(64) std::int32_t y[kCapacity];
  alignas(64) std::int32_t degrees[kCapacity];
  std::int64_t packed[kCapacity];
  int count;
};

}  // namespace pavo
#endif

HWY_BEFORE_NAMESPACE();
namespace pavo::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The directions of the gradients in whole degrees, 0..360. No fused multiply-add: the same bits on every target.
void directions(Gradients& g) {
  const hn::CappedTag<std::int32_t, 16> di;
  const hn::RebindToFloat<decltype(di)> df;
  for (int i = 0; i < g.count; i += static_cast<int>(hn::Lanes(di))) {
    const auto x = hn::ConvertTo(df, hn::Load(di, g.x + i));
    const auto y = hn::ConvertTo(df, hn::Load(di, g.y + i));
    const auto ax = hn::Abs(x), ay = hn::Abs(y);
    const auto z = hn::Div(hn::Min(ax, ay), hn::Max(hn::Max(ax, ay), hn::Set(df, 1.0f)));
    // atan(z) in degrees for z in [0, 1], minimax, within 0.005.
    const auto zz = hn::Mul(z, z);
    auto angle = hn::Add(hn::Mul(zz, hn::Set(df, -2.2337561f)), hn::Set(df, 8.3803269f));
    angle = hn::Add(hn::Mul(zz, angle), hn::Set(df, -18.401966f));
    angle = hn::Mul(z, hn::Add(hn::Mul(zz, angle), hn::Set(df, 57.250734f)));
    angle = hn::IfThenElse(hn::Gt(ay, ax), hn::Sub(hn::Set(df, 90.0f), angle), angle);
    angle = hn::IfThenElse(hn::Lt(x, hn::Zero(df)), hn::Sub(hn::Set(df, 180.0f), angle), angle);
    angle = hn::IfThenElse(hn::Lt(y, hn::Zero(df)), hn::Sub(hn::Set(df, 360.0f), angle), angle);
    hn::Store(hn::NearestInt(angle), di, g.degrees + i);
  }
}

}  // namespace pavo::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pavo {
HWY_EXPORT(directions);

namespace {

constexpr int kSteps = SurfTables::kOrientationSteps;
constexpr int kRadius = SurfTables::kOrientationRadius;

void sample_gradients(const SurfTables& t, const Integral& integral, float center_x, float center_y, Gradients& g) {
  int left[kSteps], top[kSteps];
  for (int i = 0; i < kSteps; ++i) {
    const float offset = static_cast<float>(i - kRadius) * t.scale - 0.5f * static_cast<float>(t.wavelet - 1);
    left[i] = static_cast<int>(std::lrint(center_x + offset));
    top[i] = static_cast<int>(std::lrint(center_y + offset));
  }
  const int half = t.wavelet / 2;
  int count = 0;
  for (int i = 0; i < kSteps; ++i) {
    if (top[i] < 0 || top[i] + t.wavelet > integral.height) continue;
    const std::uint32_t* row0 = integral.sums + top[i] * integral.pitch;
    const std::uint32_t* row1 = row0 + half * integral.pitch;
    const std::uint32_t* row2 = row1 + half * integral.pitch;
    for (int j = kRadius - t.circle[i]; j <= kRadius + t.circle[i]; ++j) {
      const int x = left[j];
      if (x < 0 || x + t.wavelet > integral.width) continue;
      const std::uint32_t diagonal = row2[x + t.wavelet] - row0[x];
      const std::uint32_t antidiagonal = row0[x + t.wavelet] - row2[x];
      const std::uint32_t right = diagonal - antidiagonal - 2 * (row2[x + half] - row0[x + half]);
      const std::uint32_t down = diagonal + antidiagonal - 2 * (row1[x + t.wavelet] - row1[x]);
      g.x[count] = static_cast<std::int32_t>(right) * t.orientation_weight[i][j];
      g.y[count] = static_cast<std::int32_t>(down) * t.orientation_weight[i][j];
      g.packed[count] = g.x[count] * (std::int64_t{1} << 32) + g.y[count];
      ++count;
    }
  }
  g.count = count;
  for (; count % 16 != 0; ++count) g.x[count] = g.y[count] = 0;
}

/// A window of 60 degrees around a multiple of 5 is made of whole slots: one for each multiple of 5 (even), one for the
/// four degrees between two of them (odd).
constexpr int kSlots = 144;
constexpr int kWindow = 23;

constexpr std::array<std::uint8_t, 361> kSlotOfDegree = [] {
  std::array<std::uint8_t, 361> slots{};
  for (int degree = 0; degree <= 360; ++degree) {
    slots[degree] = static_cast<std::uint8_t>((2 * (degree / 5) + (degree % 5 != 0)) % kSlots);
  }
  return slots;
}();

Direction longest_window(const Gradients& g) {
  std::int64_t slots[kSlots + kWindow + 1] = {};
  for (int i = 0; i < g.count; ++i) slots[kSlotOfDegree[g.degrees[i]]] += g.packed[i];
  std::copy_n(slots, kWindow + 1, slots + kSlots);
  std::int64_t sum = 0;
  for (int i = 1; i <= kWindow; ++i) sum += slots[i];  // odd slots begin and end a window: it is centred on an even one
  Direction best;
  float longest = 0;
  for (int first = 1; first < kSlots; first += 2) {
    const auto low = static_cast<std::int32_t>(sum);
    const auto x = static_cast<float>(static_cast<std::int32_t>((sum - low) >> 32)), y = static_cast<float>(low);
    const float length = x * x + y * y;
    if (length > longest) {
      longest = length;
      best = {x, y};
    }
    sum += slots[first + kWindow] + slots[first + kWindow + 1] - slots[first] - slots[first + 1];
  }
  return best;
}

}  // namespace

Integral make_integral(ImageView image, std::uint32_t* sums) {
  const std::ptrdiff_t pitch = image.width + 1;
  std::fill_n(sums, pitch, 0u);
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* pixels = image.row(y);
    const std::uint32_t* above = sums + y * pitch + 1;
    std::uint32_t* row = sums + (y + 1) * pitch;
    *row++ = 0;
    std::uint32_t sum = 0;
    for (int x = 0; x < image.width; ++x) {
      sum += pixels[x];
      row[x] = above[x] + sum;
    }
  }
  return {sums, pitch, image.width, image.height};
}

Direction dominant_gradient(const SurfTables& tables, const Integral& integral, float x, float y) {
  Gradients gradients;
  sample_gradients(tables, integral, x, y, gradients);
  HWY_DYNAMIC_DISPATCH(directions)(gradients);
  return longest_window(gradients);
}

}  // namespace pavo
#endif  // HWY_ONCE
