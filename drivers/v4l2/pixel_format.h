// The pixel formats that pavo takes from a camera, in the order in which it likes them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "types/encoded_image.h"

namespace pavo::v4l2 {

struct PixelFormat {
  std::uint32_t fourcc;
  std::string_view name;  ///< as it is written in a config and shown: "YUYV"
  Encoding encoding;      ///< of the bytes that are taken over: of NV12 the luma plane only
  int row_bytes_x2;       ///< bytes of one row for every two pixels; 0: compressed
};

/// Gray first, since nothing has to be converted; then what has its luma lying beside the colour; then what is
/// compressed, and costs its decoding; then what luma has to be computed from.
std::span<const PixelFormat> pixel_formats();

/// Nothing where it is none of ours.
std::optional<PixelFormat> pixel_format_of(std::uint32_t fourcc);
std::optional<PixelFormat> pixel_format_named(std::string_view name);

/// "YUYV"; what cannot be printed is '?'.
std::string fourcc_text(std::uint32_t fourcc);

}  // namespace pavo::v4l2
