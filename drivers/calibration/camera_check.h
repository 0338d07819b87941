// What every calibration is checked for, whatever file it comes from.
#pragma once

#include <span>
#include <string>

#include "types/camera.h"

namespace pavo {

/// A place in a calibration file, for messages.
struct Place {
  std::string file;
  int line = 0;
  std::string key;
};

/// fx, fy, cx, cy from a 3x3 (stride 3) or 3x4 (stride 4) row-major matrix. Throws where it is no camera matrix.
void set_intrinsics(Camera& camera, std::span<const double> matrix, std::size_t stride, const Place& place);
void set_intrinsics(Camera& camera, double fx, double fy, double cx, double cy, const Place& place);

/// Throws where the principal point is absurdly far outside an image of width x height.
void check_principal_point(const Camera& camera, int width, int height, const Place& place);

void set_size(Camera& camera, double width, double height, const Place& place);

/// Throws where there are more coefficients than `lens` has, unless the surplus is zero.
/// A radial-tangential lens without distortion becomes rectified.
void set_distortion(Camera& camera, Lens lens, std::span<const double> coefficients, const Place& place);

}  // namespace pavo
