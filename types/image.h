// 8-bit gray images: what the camera sees, in a memory that is allocated once and used again for every frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>

namespace pavo {

/// Borrowed gray pixels, row-major. Pixel (x, y) has its centre at the integer coordinates (x, y); (0, 0) is top left.
struct ImageView {
  const std::uint8_t* data = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;  ///< bytes from one row to the next, at least width

  const std::uint8_t* row(int y) const { return data + y * stride; }
  std::uint8_t at(int x, int y) const { return row(y)[x]; }
  bool empty() const { return width == 0 || height == 0; }
};

/// An owned gray image. resize() keeps its memory, so that a frame slot allocates only when a larger frame than ever
/// before comes. Rows start at multiples of 64 bytes, and kSlack readable bytes follow the last one, so that SIMD loads
/// need no special case at the right edge. Not thread-safe.
class Image {
 public:
  static constexpr std::size_t kAlignment = 64;
  static constexpr std::size_t kSlack = 64;

  Image() = default;
  Image(int width, int height) { resize(width, height); }

  /// The pixels' values are undefined afterwards, but initialised (to whatever was there, at first 0).
  void resize(int width, int height) {
    const std::size_t stride = (static_cast<std::size_t>(width) + kAlignment - 1) / kAlignment * kAlignment;
    const std::size_t bytes = stride * static_cast<std::size_t>(height) + kSlack;
    if (bytes > capacity_) {
      data_.reset(static_cast<std::uint8_t*>(
          std::aligned_alloc(kAlignment, (bytes + kAlignment - 1) / kAlignment * kAlignment)));
      if (!data_) throw std::bad_alloc();
      std::uninitialized_fill_n(data_.get(), bytes, std::uint8_t{0});
      capacity_ = bytes;
    }
    width_ = width;
    height_ = height;
    stride_ = static_cast<std::ptrdiff_t>(stride);
  }

  int width() const { return width_; }
  int height() const { return height_; }
  std::ptrdiff_t stride() const { return stride_; }
  bool empty() const { return width_ == 0 || height_ == 0; }
  std::uint8_t* row(int y) { return data_.get() + y * stride_; }
  const std::uint8_t* row(int y) const { return data_.get() + y * stride_; }
  std::uint8_t& at(int x, int y) { return row(y)[x]; }
  std::uint8_t at(int x, int y) const { return row(y)[x]; }
  ImageView view() const { return {data_.get(), width_, height_, stride_}; }

 private:
  struct Free {
    void operator()(std::uint8_t* p) const { std::free(p); }
  };
  std::unique_ptr<std::uint8_t[], Free> data_;
  std::size_t capacity_ = 0;
  int width_ = 0;
  int height_ = 0;
  std::ptrdiff_t stride_ = 0;
};

}  // namespace pavo
