// The decoders behind Decode, one for each kind of bytes. All throw std::runtime_error with one line.
#pragma once

#include <turbojpeg.h>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "types/encoded_image.h"
#include "types/image.h"

namespace pavo::decode_detail {

using Bytes = std::span<const std::uint8_t>;

/// Called as soon as the header tells the size, before memory is taken for the image; throws where it is not the one.
class SizeCheck {
 public:
  SizeCheck(int expected_width, int expected_height) : width_(expected_width), height_(expected_height) {}
  void operator()(std::int64_t width, std::int64_t height) const;

 private:
  int width_;
  int height_;
};

struct TurboJpegDelete {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using TurboJpeg = std::unique_ptr<void, TurboJpegDelete>;

bool is_jpeg(Bytes bytes);
bool is_png(Bytes bytes);
bool is_netpbm(Bytes bytes);
bool is_bmp(Bytes bytes);
bool is_tiff(Bytes bytes);

void decode_jpeg(Bytes bytes, const SizeCheck& check_size, TurboJpeg& decoder, Image& out);
void decode_png(Bytes bytes, const SizeCheck& check_size, std::vector<std::uint8_t*>& rows, Image& out);
void decode_netpbm(Bytes bytes, const SizeCheck& check_size, Image& out);
/// BMP and TIFF, by OpenCV, after a look at the header.
void decode_bmp(Bytes bytes, const SizeCheck& check_size, Image& out);
void decode_tiff(Bytes bytes, const SizeCheck& check_size, Image& out);
void decode_uncompressed(const EncodedImage& frame, const SizeCheck& check_size, Image& out);

bool is_bayer(Encoding encoding);
/// The luma of the bilinear interpolation, in one step. At the border the mosaic is mirrored. `out` has its size, and
/// the frame enough bytes.
void luma_of_bayer(const EncodedImage& frame, Image& out);

/// BT.601 luma, rounded: (77 R + 150 G + 29 B + 128) / 256. Rows do not overlap.
void luma_of_bgr(const std::uint8_t* bgr, int width, std::uint8_t* gray);
void luma_of_rgb(const std::uint8_t* rgb, int width, std::uint8_t* gray);

}  // namespace pavo::decode_detail
