// The size of an encoded image, from its header.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace pavo {

struct ImageSize {
  int width = 0;
  int height = 0;
};

/// Of a PNG, JPEG, PNM, BMP or TIFF file, without decoding it. Nothing where the bytes are none of these, or too few.
/// Any thread.
std::optional<ImageSize> image_size(std::span<const std::uint8_t> bytes);

}  // namespace pavo
