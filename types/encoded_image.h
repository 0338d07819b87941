// An image as it comes from a file or a camera, before it is decoded to 8-bit gray.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pavo {

enum class Encoding {
  file,   ///< the bytes of an image file (PNG, JPEG, PGM, ...): what it is, its first bytes tell
  gray8,  ///< rows of `stride` bytes, 1 byte a pixel
  bgr24,  ///< rows of `stride` bytes, 3 bytes a pixel
  rgb24,
  yuyv,         ///< 2 bytes a pixel: luma, and the colour of two pixels in turn
  uyvy,         ///< the same, the colour first
  gray16,       ///< 2 bytes a pixel, the lower one first
  bayer_bggr8,  ///< 1 byte a pixel behind a colour filter; named by the first four: two of row 0, two of row 1
  bayer_gbrg8,
  bayer_grbg8,
  bayer_rggb8,
};

struct EncodedImage {
  Encoding encoding = Encoding::file;
  int width = 0;  ///< of the uncompressed encodings; for `file` the decoder finds it out
  int height = 0;
  std::ptrdiff_t stride = 0;        ///< bytes from one row to the next; for `file` 0
  std::vector<std::uint8_t> bytes;  ///< keeps its capacity from frame to frame
};

}  // namespace pavo
