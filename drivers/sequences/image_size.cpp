#include "drivers/sequences/image_size.h"

#include <algorithm>
#include <array>

namespace pavo {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::uint32_t kLargestSide = 65535;

std::uint32_t big_endian(Bytes bytes, std::size_t at, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value = value << 8 | bytes[at + i];
  return value;
}

std::uint32_t little_endian(Bytes bytes, std::size_t at, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = count; i-- > 0;) value = value << 8 | bytes[at + i];
  return value;
}

std::optional<ImageSize> checked(std::uint32_t width, std::uint32_t height) {
  if (width == 0 || height == 0 || width > kLargestSide || height > kLargestSide) return std::nullopt;
  return ImageSize{static_cast<int>(width), static_cast<int>(height)};
}

bool starts_with(Bytes bytes, std::initializer_list<std::uint8_t> magic) {
  return bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin());
}

std::optional<ImageSize> png_size(Bytes bytes) {
  if (bytes.size() < 24) return std::nullopt;
  return checked(big_endian(bytes, 16, 4), big_endian(bytes, 20, 4));
}

/// Walks over the segments up to the frame header (SOF0 ... SOF15, without DHT, JPG and DAC).
std::optional<ImageSize> jpeg_size(Bytes bytes) {
  std::size_t at = 2;
  while (at + 4 <= bytes.size()) {
    if (bytes[at] != 0xFF) return std::nullopt;
    const std::uint8_t marker = bytes[at + 1];
    if (marker == 0xFF) {  // a fill byte
      ++at;
      continue;
    }
    const bool standalone = marker == 0x01 || (marker >= 0xD0 && marker <= 0xD8);
    if (standalone) {
      at += 2;
      continue;
    }
    if (marker == 0xDA || marker == 0xD9) return std::nullopt;  // picture data, or the end, before any frame header
    const bool frame_header = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (frame_header) {
      if (at + 9 > bytes.size()) return std::nullopt;
      return checked(big_endian(bytes, at + 7, 2), big_endian(bytes, at + 5, 2));
    }
    at += 2 + std::max<std::uint32_t>(2, big_endian(bytes, at + 2, 2));
  }
  return std::nullopt;
}

/// "P5", then width and height, parted by blanks and comments.
std::optional<ImageSize> pnm_size(Bytes bytes) {
  std::array<std::uint32_t, 2> size{};
  std::size_t at = 2;
  for (std::uint32_t& side : size) {
    while (at < bytes.size() && (bytes[at] == ' ' || (bytes[at] >= '\t' && bytes[at] <= '\r') || bytes[at] == '#')) {
      if (bytes[at] == '#')
        at = static_cast<std::size_t>(std::find(bytes.begin() + at, bytes.end(), '\n') - bytes.begin());
      if (at < bytes.size()) ++at;
    }
    for (; at < bytes.size() && bytes[at] >= '0' && bytes[at] <= '9' && side <= kLargestSide; ++at) {
      side = side * 10 + (bytes[at] - '0');
    }
  }
  return checked(size[0], size[1]);
}

/// BITMAPINFOHEADER and its followers: the height is negative where the rows go from top to bottom.
std::optional<ImageSize> bmp_size(Bytes bytes) {
  if (bytes.size() < 26) return std::nullopt;
  const std::uint32_t height = little_endian(bytes, 22, 4);
  return checked(little_endian(bytes, 18, 4), height & 0x80000000u ? 0u - height : height);
}

/// The tags ImageWidth (256) and ImageLength (257) of the first directory, as SHORT (3) or LONG (4).
std::optional<ImageSize> tiff_size(Bytes bytes, bool is_little) {
  const auto number = [&](std::size_t at, std::size_t count) {
    return is_little ? little_endian(bytes, at, count) : big_endian(bytes, at, count);
  };
  if (bytes.size() < 8) return std::nullopt;
  const std::size_t directory = number(4, 4);
  if (directory + 2 > bytes.size()) return std::nullopt;
  const std::size_t entries = number(directory, 2);
  std::uint32_t width = 0, height = 0;
  for (std::size_t at = directory + 2, i = 0; i < entries && at + 12 <= bytes.size(); ++i, at += 12) {
    const std::uint32_t tag = number(at, 2), value = number(at + 8, number(at + 2, 2) == 3 ? 2 : 4);
    if (tag == 256) width = value;
    if (tag == 257) height = value;
  }
  return checked(width, height);
}

}  // namespace

std::optional<ImageSize> image_size(Bytes bytes) {
  if (starts_with(bytes, {0x89, 'P', 'N', 'G', 0x0D, 0x0A, 0x1A, 0x0A})) return png_size(bytes);
  if (starts_with(bytes, {0xFF, 0xD8})) return jpeg_size(bytes);
  if (bytes.size() > 2 && bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '6') return pnm_size(bytes);
  if (starts_with(bytes, {'B', 'M'})) return bmp_size(bytes);
  if (starts_with(bytes, {'I', 'I', 42, 0})) return tiff_size(bytes, true);
  if (starts_with(bytes, {'M', 'M', 0, 42})) return tiff_size(bytes, false);
  return std::nullopt;
}

}  // namespace pavo
