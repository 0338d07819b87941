// libpng itself rather than cv::imdecode: errors arrive as exceptions instead of lines on stderr and half a picture,
// and the rows go straight into the image.
#include <png.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>

#include "stages/decode/decode.h"
#include "stages/decode/formats.h"

namespace pavo::decode_detail {
namespace {

struct PngReader {
  Bytes bytes;
  std::size_t at = 0;
  std::array<char, 160> error{};
};

/// libpng is C: no exception may pass through it. The message is kept, and the jump lands in a frame without
/// destructors.
[[noreturn]] void on_error(png_structp png, png_const_charp message) {
  auto& reader = *static_cast<PngReader*>(png_get_error_ptr(png));
  std::snprintf(reader.error.data(), reader.error.size(), "%s", message);
  png_longjmp(png, 1);
}

/// Warnings concern ancillary chunks (a broken text, a colour profile), never pixels, with one exception: a checksum.
void on_warning(png_structp, png_const_charp) {}

void read_bytes(png_structp png, png_bytep out, png_size_t count) {
  auto& reader = *static_cast<PngReader*>(png_get_io_ptr(png));
  if (count > reader.bytes.size() - reader.at) png_error(png, "premature end of the file");
  std::memcpy(out, reader.bytes.data() + reader.at, count);
  reader.at += count;
}

class Decoder {
 public:
  explicit Decoder(Bytes bytes) {
    reader_.bytes = bytes;
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader_, on_error, on_warning);
    info_ = png_ ? png_create_info_struct(png_) : nullptr;
    if (!info_) {
      png_destroy_read_struct(&png_, nullptr, nullptr);
      throw std::bad_alloc();
    }
    png_set_read_fn(png_, &reader_, read_bytes);
  }
  ~Decoder() { png_destroy_read_struct(&png_, &info_, nullptr); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  void read_header() {
    if (!try_header()) fail();
  }
  void read_pixels(std::uint8_t** rows) {
    if (!try_pixels(rows)) fail();
  }
  png_uint_32 width() const { return png_get_image_width(png_, info_); }
  png_uint_32 height() const { return png_get_image_height(png_, info_); }

 private:
  [[noreturn]] void fail() const { throw std::runtime_error(std::string("PNG: ") + reader_.error.data()); }

  bool try_header() {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_set_user_limits(png_, 1U << 24, 1U << 24);
    png_set_chunk_malloc_max(png_, 1U << 20);  // of texts and profiles, which nobody reads
    png_set_chunk_cache_max(png_, 16);
    png_set_benign_errors(png_, 0);  // what libpng calls benign may be a picture that is not whole
    png_set_crc_action(png_, PNG_CRC_ERROR_QUIT, PNG_CRC_WARN_DISCARD);
    png_read_info(png_, info_);
    return true;
  }

  bool try_pixels(std::uint8_t** rows) {
    if (setjmp(png_jmpbuf(png_))) return false;
    const png_byte colours = png_get_color_type(png_, info_);
    png_set_strip_16(png_);
    png_set_strip_alpha(png_);
    if (colours == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png_);
    if (colours == PNG_COLOR_TYPE_GRAY && png_get_bit_depth(png_, info_) < 8) png_set_expand_gray_1_2_4_to_8(png_);
    if (colours & PNG_COLOR_MASK_COLOR) png_set_rgb_to_gray(png_, 1, 0.299, 0.587);
    png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    if (png_get_rowbytes(png_, info_) != width()) png_error(png_, "an unexpected layout of the pixels");
    png_read_image(png_, rows);
    png_read_end(png_, nullptr);
    return true;
  }

  PngReader reader_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

}  // namespace

bool is_png(Bytes b) {
  constexpr std::array<std::uint8_t, 8> signature{0x89, 'P', 'N', 'G', 0x0D, 0x0A, 0x1A, 0x0A};
  return b.size() >= signature.size() && std::equal(signature.begin(), signature.end(), b.begin());
}

void decode_png(Bytes bytes, const SizeCheck& check_size, std::vector<std::uint8_t*>& rows, Image& out) {
  Decoder decoder(bytes);
  decoder.read_header();
  check_size(decoder.width(), decoder.height());
  out.resize(static_cast<int>(decoder.width()), static_cast<int>(decoder.height()));
  rows.resize(decoder.height());
  for (std::size_t y = 0; y < rows.size(); ++y) rows[y] = out.row(static_cast<int>(y));
  decoder.read_pixels(rows.data());
}

}  // namespace pavo::decode_detail
