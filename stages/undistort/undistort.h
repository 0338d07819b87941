// Takes the lens out of the picture: after it, straight lines of the world are straight.
#pragma once

#include <hwy/aligned_allocator.h>
#include <cstdint>
#include <vector>

#include "types/camera.h"
#include "types/image.h"

namespace pavo {

/// Bilinear remap by maps that are computed once: a pixel u of the rectified image shows what the source shows at
///     project(source, unproject(rectified_camera(), u)),                              (types/lens.h)
/// with source positions rounded to 1/128 pixel. Values lie within 2 gray levels of cv::remap's on the exact map.
/// A rectified source with alpha = 0 is copied, to the bit; a graph without the stage is cheaper.
///
/// A parallel stage without scratch: const calls from any thread; does not block; allocates only to grow `image`.
class Undistort {
 public:
  /// `alpha` in [0, 1] goes linearly from the source's K (0) to the K that shows every pixel of the source (1), as
  /// cv::getOptimalNewCameraMatrix has it (only directions within 80 degrees of the axis count).
  /// Throws std::invalid_argument, naming the value, when the camera or alpha is not usable.
  explicit Undistort(const Camera& source, double alpha = 0);

  /// The pinhole camera that the rectified images are of: same size, lens = rectified.
  Camera rectified_camera() const { return rectified_; }

  /// 255 where the pixel's four source pixels exist, 0 elsewhere (there the image is 0). Lives as long as the stage.
  ImageView valid_mask() const { return valid_.view(); }

  /// Throws std::runtime_error, naming both sizes, when `raw` has another size than the source camera.
  void operator()(const Image& raw, Image& image) const;

 private:
  void compute_maps(const Camera& source);

  Camera rectified_;
  bool identity_ = false;
  Image valid_;
  /// Per output pixel, rows of map_stride_: the offset in bytes of the top left source pixel in an Image of this width,
  /// and the weights in 1/128: horizontal in the low byte, vertical in the high one.
  std::size_t map_stride_ = 0;
  hwy::AlignedFreeUniquePtr<std::int32_t[]> offset_;
  hwy::AlignedFreeUniquePtr<std::uint16_t[]> weight_;
};

/// The K (as a rectified camera) of `source` widened by alpha, as Undistort explains.
Camera widened_camera(const Camera& source, double alpha);

}  // namespace pavo
