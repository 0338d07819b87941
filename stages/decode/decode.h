// From the bytes of an image file, or of a camera, to 8-bit gray.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "types/encoded_image.h"
#include "types/image.h"

namespace pavo {

/// Decodes JPEG (libturbojpeg, straight to gray), PNG (libpng), PGM and PPM (ASCII and binary), BMP and TIFF (OpenCV),
/// and the uncompressed frames of cameras and films: gray of 8 and 16 bits, YUYV and UYVY (whose luma is taken as it
/// is), RGB and BGR, and 8-bit Bayer mosaics (luma of the bilinear interpolation, with weights of 1/64).
///
/// Colour becomes BT.601 luma, Y = 0.299 R + 0.587 G + 0.114 B; a JPEG's own Y is taken as it is. Samples of 16 bits
/// become 8 by keeping the upper 8 (v >> 8), as cv::imread does, so all agree with cv::imread(IMREAD_GRAYSCALE) within
/// one level. An alpha channel is dropped. The orientation of EXIF is not applied: a calibration is of the sensor's
/// rows and columns.
///
/// A frame is an error (std::runtime_error, one line), never a part of a picture, when its bytes are truncated or
/// corrupt as far as the format can tell (where libjpeg only warns, too), when its format is none of the above (CMYK
/// JPEGs are not), when its size is not the expected one, or when it has more than kMaxPixels, which is found out
/// before any memory is taken for it. Bytes behind the end of the image are ignored, and up to 64 that a webcam has
/// filled in before a JPEG's end; its Huffman tables may be left out, as webcams do. Safe against any bytes.
///
/// A parallel stage: any thread may call it with a Scratch of its own. Does not block. What the libraries allocate
/// inside a decoder is theirs; uncompressed frames allocate nothing once `raw` has its size.
class Decode {
 public:
  static constexpr std::int64_t kMaxPixels = std::int64_t{64} << 20;

  class Scratch;

  /// Width and height that every frame must have; 0 = any.
  explicit Decode(int expected_width = 0, int expected_height = 0);

  void operator()(const EncodedImage& encoded, Image& raw, Scratch& scratch) const;

 private:
  int expected_width_;
  int expected_height_;
};

/// The decoder handles and the memory of one caller.
class Decode::Scratch {
 public:
  Scratch();
  ~Scratch();
  Scratch(Scratch&&) noexcept;
  Scratch& operator=(Scratch&&) noexcept;

  struct Parts;
  Parts& parts() { return *parts_; }

 private:
  std::unique_ptr<Parts> parts_;
};

}  // namespace pavo
