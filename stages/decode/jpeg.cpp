#include <algorithm>
#include <array>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "stages/decode/formats.h"

namespace pavo::decode_detail {
namespace {

// A warning of libjpeg's (a premature end, corrupt data) is a picture with a gray part: no frame to estimate a motion
// from. And a progressive file of a few kB can ask for hours of scans.
bool decode_strictly(TurboJpeg& decoder, Bytes bytes, Image& out) {
  return tjDecompress2(decoder.get(), bytes.data(), static_cast<unsigned long>(bytes.size()), out.row(0), out.width(),
                       static_cast<int>(out.stride()), out.height(), TJPF_GRAY,
                       TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS) == 0;
}

// Many webcams fill the bytes up to a multiple of what their bus likes, before the end's marker instead of behind it.
// The same without the filling, where it is that which libjpeg has warned of; else nothing.
std::vector<std::uint8_t> without_filling(TurboJpeg& decoder, Bytes bytes) {
  constexpr unsigned kMost = 64;
  constexpr std::array<std::uint8_t, 2> kEnd{0xFF, 0xD9};
  unsigned filling = 0;
  int whole = 0;
  std::sscanf(tjGetErrorStr2(decoder.get()), "Corrupt JPEG data: %u extraneous bytes before marker 0xd9%n", &filling,
              &whole);
  const auto end = std::find_end(bytes.begin(), bytes.end(), kEnd.begin(), kEnd.end());
  if (whole == 0 || filling > kMost || end == bytes.end() || end - bytes.begin() < filling) return {};
  std::vector<std::uint8_t> trimmed(bytes.begin(), end - filling);
  trimmed.insert(trimmed.end(), kEnd.begin(), kEnd.end());
  return trimmed;
}

}  // namespace

bool is_jpeg(Bytes b) {
  return b.size() >= 3 && b[0] == 0xFF && b[1] == 0xD8 && b[2] == 0xFF;
}

void decode_jpeg(Bytes bytes, const SizeCheck& check_size, TurboJpeg& decoder, Image& out) {
  if (!decoder) decoder.reset(tjInitDecompress());
  if (!decoder) throw std::runtime_error(std::string("libturbojpeg cannot start: ") + tjGetErrorStr2(nullptr));
  const auto fail = [&] { throw std::runtime_error(std::string("JPEG: ") + tjGetErrorStr2(decoder.get())); };

  const auto size = static_cast<unsigned long>(bytes.size());
  int width = 0, height = 0, subsampling = 0, colours = 0;
  if (tjDecompressHeader3(decoder.get(), bytes.data(), size, &width, &height, &subsampling, &colours) != 0) fail();
  check_size(width, height);
  if (colours == TJCS_CMYK || colours == TJCS_YCCK)
    throw std::runtime_error("JPEG: four colours (CMYK) are not supported; convert the image to gray or RGB");
  out.resize(width, height);
  if (decode_strictly(decoder, bytes, out)) return;
  const std::vector<std::uint8_t> trimmed = without_filling(decoder, bytes);
  if (trimmed.empty() || !decode_strictly(decoder, trimmed, out)) fail();
}

}  // namespace pavo::decode_detail
