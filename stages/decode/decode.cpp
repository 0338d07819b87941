#include "stages/decode/decode.h"

#include <stdexcept>
#include <string>

#include "stages/decode/formats.h"

namespace pavo {

struct Decode::Scratch::Parts {
  decode_detail::TurboJpeg jpeg;
  std::vector<std::uint8_t*> rows;
};

Decode::Scratch::Scratch() : parts_(std::make_unique<Parts>()) {}
Decode::Scratch::~Scratch() = default;
Decode::Scratch::Scratch(Scratch&&) noexcept = default;
Decode::Scratch& Decode::Scratch::operator=(Scratch&&) noexcept = default;

Decode::Decode(int expected_width, int expected_height)
    : expected_width_(expected_width), expected_height_(expected_height) {
  if (expected_width < 0 || expected_height < 0)
    throw std::invalid_argument("decode: the expected size is " + std::to_string(expected_width) + "x" +
                                std::to_string(expected_height) + "; expected 0 (any) or more");
}

void Decode::operator()(const EncodedImage& encoded, Image& raw, Scratch& scratch) const {
  using namespace decode_detail;
  const SizeCheck check_size(expected_width_, expected_height_);
  if (encoded.encoding != Encoding::file) return decode_uncompressed(encoded, check_size, raw);

  const Bytes bytes(encoded.bytes);
  if (bytes.empty()) throw std::runtime_error("the frame has no bytes; expected an image");
  if (is_jpeg(bytes)) return decode_jpeg(bytes, check_size, scratch.parts().jpeg, raw);
  if (is_png(bytes)) return decode_png(bytes, check_size, scratch.parts().rows, raw);
  if (is_netpbm(bytes)) return decode_netpbm(bytes, check_size, raw);
  if (is_bmp(bytes)) return decode_bmp(bytes, check_size, raw);
  if (is_tiff(bytes)) return decode_tiff(bytes, check_size, raw);
  throw std::runtime_error("the frame's " + std::to_string(bytes.size()) +
                           " bytes are no image of a known format; expected JPEG, PNG, PGM, PPM, BMP or TIFF");
}

void decode_detail::SizeCheck::operator()(std::int64_t width, std::int64_t height) const {
  const auto named = [](std::int64_t w, std::int64_t h) {
    const auto side = [](std::int64_t n) { return n == 0 ? std::string("any") : std::to_string(n); };
    return side(w) + "x" + side(h);
  };
  const auto plain = [](std::int64_t w, std::int64_t h) { return std::to_string(w) + "x" + std::to_string(h); };
  if ((width_ != 0 && width != width_) || (height_ != 0 && height != height_))
    throw std::runtime_error("the frame is " + plain(width, height) + ", expected " + named(width_, height_));
  if (width < 1 || height < 1) throw std::runtime_error("the frame is empty: " + plain(width, height));
  if (width > Decode::kMaxPixels || height > Decode::kMaxPixels / width)
    throw std::runtime_error("the frame is " + plain(width, height) + ", larger than 64 megapixels");
}

}  // namespace pavo
