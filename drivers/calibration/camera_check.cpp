#include "drivers/calibration/camera_check.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "drivers/calibration/text.h"

namespace pavo {
namespace {

constexpr double kLargestFocalLengthPx = 1e6;
constexpr double kLargestSidePx = 32767;

[[noreturn]] void fail(const Place& place, const std::string& what) {
  fail_at(place.file, place.line, place.key + " " + what);
}

std::string text(double value) {
  std::ostringstream stream;
  stream << value;
  return stream.str();
}

}  // namespace

void set_intrinsics(Camera& camera, double fx, double fy, double cx, double cy, const Place& place) {
  for (const double f : {fx, fy}) {
    // A focal length below a pixel is one that was divided by the image's width, or no calibration at all.
    if (!(f >= 1 && f <= kLargestFocalLengthPx)) {
      fail(place, "has the focal length " + text(f) + ": expected pixels, 1 or more; calibrate the camera");
    }
  }
  if (!std::isfinite(cx) || !std::isfinite(cy)) fail(place, "has no finite principal point: expected cx, cy in pixels");
  camera.fx = fx;
  camera.fy = fy;
  camera.cx = cx;
  camera.cy = cy;
}

void set_intrinsics(Camera& camera, std::span<const double> matrix, std::size_t stride, const Place& place) {
  const auto at = [&](std::size_t row, std::size_t column) { return matrix[row * stride + column]; };
  // The focal lengths first: an uncalibrated camera_info is all zeros, and that is what its message should say.
  set_intrinsics(camera, at(0, 0), at(1, 1), at(0, 2), at(1, 2), place);
  if (at(0, 1) != 0 || at(1, 0) != 0 || at(2, 0) != 0 || at(2, 1) != 0 || at(2, 2) != 1) {
    fail(place, "is no camera matrix: expected rows 'fx 0 cx', '0 fy cy', '0 0 1' (skew is not supported)");
  }
}

void check_principal_point(const Camera& camera, int width, int height, const Place& place) {
  // A crop may move it out of the image, but hardly by more than half of the image's size.
  const auto plausible = [](double c, int size) { return c >= -0.5 * size && c <= 1.5 * size; };
  if (plausible(camera.cx, width) && plausible(camera.cy, height)) return;
  fail(place, "has its principal point at (" + text(camera.cx) + ", " + text(camera.cy) +
                  "), far outside the image of " + std::to_string(width) + "x" + std::to_string(height) +
                  ": expected pixels of this image; calibrate at this size");
}

void set_size(Camera& camera, double width, double height, const Place& place) {
  for (const double side : {width, height}) {
    if (!(side >= 1 && side <= kLargestSidePx && side == std::floor(side))) {
      fail(place,
           "has the image size " + text(width) + "x" + text(height) + ": expected whole numbers from 1 to 32767");
    }
  }
  camera.width = static_cast<int>(width);
  camera.height = static_cast<int>(height);
}

void set_distortion(Camera& camera, Lens lens, std::span<const double> coefficients, const Place& place) {
  const std::size_t most = lens == Lens::radial_tangential ? 8 : lens == Lens::equidistant ? 4 : 0;
  if (lens == Lens::equidistant && coefficients.size() != 4) {
    fail(place,
         "has " + std::to_string(coefficients.size()) + " values: expected the 4 of an equidistant lens, k1 k2 k3 k4");
  }
  constexpr std::size_t kCounts[] = {0, 4, 5, 8, 12, 14};
  if (lens == Lens::radial_tangential && std::ranges::find(kCounts, coefficients.size()) == std::end(kCounts)) {
    fail(place,
         "has " + std::to_string(coefficients.size()) + " values: expected 4, 5 or 8 (k1 k2 p1 p2 [k3 [k4 k5 k6]])");
  }
  camera.distortion = {};
  for (std::size_t i = 0; i < coefficients.size(); ++i) {
    if (i < most) {
      camera.distortion[i] = coefficients[i];
    } else if (coefficients[i] != 0) {
      fail(place, "has a nonzero coefficient at place " + std::to_string(i + 1) + ": only the first " +
                      std::to_string(most) + " are supported; calibrate with fewer");
    }
  }
  const bool none = std::ranges::all_of(camera.distortion, [](double k) { return k == 0; });
  camera.lens = lens == Lens::radial_tangential && none ? Lens::rectified : lens;
}

}  // namespace pavo
