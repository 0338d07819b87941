#include "drivers/v4l2/pixel_format.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>

namespace pavo::v4l2 {
namespace {

constexpr std::array<PixelFormat, 16> kFormats{{
    {V4L2_PIX_FMT_GREY, "GREY", Encoding::gray8, 2},
    {V4L2_PIX_FMT_NV12, "NV12", Encoding::gray8, 2},
    {V4L2_PIX_FMT_NV12M, "NM12", Encoding::gray8, 2},  // NV12 with the colours in a plane of their own
    {V4L2_PIX_FMT_NV21, "NV21", Encoding::gray8, 2},
    {V4L2_PIX_FMT_YUV420, "YU12", Encoding::gray8, 2},
    {V4L2_PIX_FMT_YUYV, "YUYV", Encoding::yuyv, 4},
    {V4L2_PIX_FMT_UYVY, "UYVY", Encoding::uyvy, 4},
    {V4L2_PIX_FMT_MJPEG, "MJPG", Encoding::file, 0},
    {V4L2_PIX_FMT_JPEG, "JPEG", Encoding::file, 0},
    {V4L2_PIX_FMT_RGB24, "RGB3", Encoding::rgb24, 6},
    {V4L2_PIX_FMT_BGR24, "BGR3", Encoding::bgr24, 6},
    {V4L2_PIX_FMT_Y16, "Y16", Encoding::gray16, 4},
    {V4L2_PIX_FMT_SBGGR8, "BA81", Encoding::bayer_bggr8, 2},
    {V4L2_PIX_FMT_SGBRG8, "GBRG", Encoding::bayer_gbrg8, 2},
    {V4L2_PIX_FMT_SGRBG8, "GRBG", Encoding::bayer_grbg8, 2},
    {V4L2_PIX_FMT_SRGGB8, "RGGB", Encoding::bayer_rggb8, 2},
}};

}  // namespace

std::span<const PixelFormat> pixel_formats() {
  return kFormats;
}

std::optional<PixelFormat> pixel_format_of(std::uint32_t fourcc) {
  const auto* const found =
      std::find_if(kFormats.begin(), kFormats.end(), [&](const PixelFormat& f) { return f.fourcc == fourcc; });
  return found == kFormats.end() ? std::nullopt : std::optional(*found);
}

std::optional<PixelFormat> pixel_format_named(std::string_view name) {
  const auto* const found =
      std::find_if(kFormats.begin(), kFormats.end(), [&](const PixelFormat& f) { return f.name == name; });
  return found == kFormats.end() ? std::nullopt : std::optional(*found);
}

std::string fourcc_text(std::uint32_t fourcc) {
  if (const auto known = pixel_format_of(fourcc)) return std::string(known->name);
  std::string text;
  for (int i = 0; i < 4; ++i) {
    const auto c = static_cast<char>(fourcc >> 8 * i & 0x7F);  // the top bit says "big endian"
    text += c > ' ' && c <= '~' ? c : '?';
  }
  return text;
}

}  // namespace pavo::v4l2
