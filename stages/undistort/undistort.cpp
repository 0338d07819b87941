#include "stages/undistort/undistort.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

#include "stages/undistort/remap.h"
#include "types/lens.h"

namespace pavo {
namespace {

using undistort_detail::kWeightBits;
constexpr int kOne = 1 << kWeightBits;

void require_usable(const Camera& camera, double alpha) {
  const auto fail = [](const std::string& what) { throw std::invalid_argument("undistort: " + what); };
  if (camera.width < 1 || camera.height < 1)
    fail("the camera's image is " + std::to_string(camera.width) + "x" + std::to_string(camera.height) +
         "; expected at least 1x1");
  if ((static_cast<std::int64_t>(camera.width) + 64) * camera.height > std::numeric_limits<std::int32_t>::max())
    fail("the camera's image is too large: offsets into it must fit 31 bits");  // rows are padded to 64 bytes
  if (!(camera.fx > 0) || !(camera.fy > 0) || !std::isfinite(camera.fx) || !std::isfinite(camera.fy))
    fail("the focal lengths must be above 0, are fx " + std::to_string(camera.fx) + ", fy " +
         std::to_string(camera.fy));
  if (!std::isfinite(camera.cx) || !std::isfinite(camera.cy)) fail("the principal point must be finite");
  for (const double k : camera.distortion)
    if (!std::isfinite(k)) fail("the distortion coefficients must be finite");
  if (!(alpha >= 0 && alpha <= 1)) fail("alpha must be in [0, 1], is " + std::to_string(alpha));
}

bool is_rectified(const Camera& camera) {
  const auto zero = [](double k) { return k == 0; };
  if (camera.lens == Lens::equidistant) return false;
  return camera.lens == Lens::rectified || std::ranges::all_of(camera.distortion, zero);
}

/// The part of the ideal image plane that the source's border is seen in.
struct Bounds {
  double left = std::numeric_limits<double>::infinity(), top = left, right = -left, bottom = -left;
  void include(const Camera& camera, double x, double y) {
    const std::optional<Eigen::Vector3d> ray = unproject(camera, {x, y});
    constexpr double kLargestAngle = 80 * std::numbers::pi / 180;  // beyond it a plane is the wrong picture
    if (!ray || !(ray->z() > std::cos(kLargestAngle))) return;
    const double u = ray->x() / ray->z(), v = ray->y() / ray->z();
    left = std::min(left, u), right = std::max(right, u);
    top = std::min(top, v), bottom = std::max(bottom, v);
  }
};

Bounds bounds_of(const Camera& camera) {
  Bounds bounds;
  for (int y = 0; y < camera.height; ++y) {
    bounds.include(camera, 0, y);
    bounds.include(camera, camera.width - 1, y);
  }
  for (int x = 0; x < camera.width; ++x) {
    bounds.include(camera, x, 0);
    bounds.include(camera, x, camera.height - 1);
  }
  return bounds;
}

}  // namespace

Camera widened_camera(const Camera& source, double alpha) {
  require_usable(source, alpha);
  Camera out = source;
  out.lens = Lens::rectified;
  out.distortion = {};
  if (alpha == 0) return out;
  const Bounds bounds = bounds_of(source);
  if (!(bounds.right > bounds.left) || !(bounds.bottom > bounds.top)) return out;
  const auto mix = [alpha](double keep, double wide) { return (1 - alpha) * keep + alpha * wide; };
  const double fx = (source.width - 1) / (bounds.right - bounds.left);
  const double fy = (source.height - 1) / (bounds.bottom - bounds.top);
  out.fx = mix(source.fx, fx);
  out.fy = mix(source.fy, fy);
  out.cx = mix(source.cx, -fx * bounds.left);
  out.cy = mix(source.cy, -fy * bounds.top);
  return out;
}

Undistort::Undistort(const Camera& source, double alpha) : rectified_(widened_camera(source, alpha)) {
  identity_ = alpha == 0 && is_rectified(source);
  valid_.resize(source.width, source.height);
  if (identity_) {
    for (int y = 0; y < valid_.height(); ++y) std::memset(valid_.row(y), 255, static_cast<std::size_t>(valid_.width()));
    return;
  }
  compute_maps(source);
}

namespace {

/// Where the source shows what the rectified camera shows at a pixel; nothing where the lens cannot see it.
class SourcePosition {
 public:
  SourcePosition(const Camera& source, const Camera& rectified)
      : source_(source), rectified_(rectified), limit_(lens_limit(source)) {}

  std::optional<Eigen::Vector2d> operator()(int x, int y) const {
    const double u = (x - rectified_.cx) / rectified_.fx, v = (y - rectified_.cy) / rectified_.fy;
    const double r = std::hypot(u, v);
    if ((source_.lens == Lens::equidistant ? std::atan(r) : r) > limit_) return std::nullopt;
    const Eigen::Vector2d p = distort(source_, {u, v});
    return Eigen::Vector2d(source_.fx * p.x() + source_.cx, source_.fy * p.y() + source_.cy);
  }

 private:
  const Camera& source_;
  const Camera& rectified_;
  double limit_;
};

/// A source coordinate in 1/128 pixels, split: the pixel before it, and the weight of the one behind it.
struct Split {
  int pixel;
  int weight;
};

std::optional<Split> split_column(double position, int size) {
  if (!(position > -1 && position < size)) return std::nullopt;
  const auto fixed = static_cast<int>(std::lround(position * kOne));
  if (fixed < 0 || fixed > (size - 1) * kOne) return std::nullopt;
  return Split{fixed >> kWeightBits, fixed & (kOne - 1)};
}

/// The last row is taken 1/128 pixel too early, so that there always is a row below (but for an image of one row).
std::optional<Split> split_row(double position, int size) {
  const std::optional<Split> split = split_column(position, size);
  if (!split || split->pixel < size - 1 || size == 1) return split;
  return Split{size - 2, kOne - 1};
}

}  // namespace

void Undistort::compute_maps(const Camera& source) {
  const int width = source.width, height = source.height;
  map_stride_ = static_cast<std::size_t>(valid_.stride());
  const std::size_t n = map_stride_ * static_cast<std::size_t>(height);
  offset_ = hwy::AllocateAligned<std::int32_t>(n);
  weight_ = hwy::AllocateAligned<std::uint16_t>(n);
  if (!offset_ || !weight_) throw std::bad_alloc();
  std::fill_n(offset_.get(), n, 0);
  std::fill_n(weight_.get(), n, std::uint16_t{0});
  const SourcePosition source_position(source, rectified_);
  for (int y = 0; y < height; ++y) {
    std::uint8_t* valid = valid_.row(y);
    std::fill_n(valid, map_stride_, std::uint8_t{0});
    for (int x = 0; x < width; ++x) {
      const std::optional<Eigen::Vector2d> position = source_position(x, y);
      if (!position) continue;
      const std::optional<Split> sx = split_column(position->x(), width), sy = split_row(position->y(), height);
      if (!sx || !sy) continue;
      const std::size_t at = static_cast<std::size_t>(y) * map_stride_ + static_cast<std::size_t>(x);
      offset_[at] = sy->pixel * static_cast<std::int32_t>(valid_.stride()) + sx->pixel;
      weight_[at] = static_cast<std::uint16_t>(sx->weight | sy->weight << 8);
      valid[x] = 255;
    }
  }
}

void Undistort::operator()(const Image& raw, Image& image) const {
  const int width = rectified_.width, height = rectified_.height;
  if (raw.width() != width || raw.height() != height)
    throw std::runtime_error("undistort: the image is " + std::to_string(raw.width()) + "x" +
                             std::to_string(raw.height()) + ", the calibration is for " + std::to_string(width) + "x" +
                             std::to_string(height) + "; use the calibration of this camera and image size");
  image.resize(width, height);
  const std::ptrdiff_t row_below = height > 1 ? raw.stride() : 0;
  for (int y = 0; y < height; ++y) {
    if (identity_) {
      std::memcpy(image.row(y), raw.row(y), static_cast<std::size_t>(width));
      continue;
    }
    const std::size_t at = static_cast<std::size_t>(y) * map_stride_;
    undistort_detail::remap_row(raw.row(0), row_below, offset_.get() + at, weight_.get() + at, valid_.row(y), width,
                                image.row(y));
  }
}

}  // namespace pavo
