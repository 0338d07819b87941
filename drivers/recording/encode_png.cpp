#include "drivers/recording/encode_png.h"

#include <zlib.h>

#include <algorithm>
#include <new>
#include <stdexcept>
#include <string_view>

namespace pavo {
namespace {

constexpr std::uint8_t kAverage = 3;
constexpr std::size_t kChunkFrame = 12;  // length, name, CRC

void put_big_endian(std::uint8_t* to, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) to[i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
}

void append_big_endian(std::vector<std::uint8_t>& bytes, std::uint32_t value) {
  bytes.resize(bytes.size() + 4);
  put_big_endian(bytes.data() + bytes.size() - 4, value);
}

/// Begins a chunk; its length and CRC are filled in by end_chunk().
std::size_t begin_chunk(std::vector<std::uint8_t>& png, std::string_view name) {
  const std::size_t at = png.size();
  png.resize(at + 4);
  png.insert(png.end(), name.begin(), name.end());
  return at;
}

void end_chunk(std::vector<std::uint8_t>& png, std::size_t at) {
  const std::size_t length = png.size() - at - 8;
  put_big_endian(png.data() + at, static_cast<std::uint32_t>(length));
  append_big_endian(png, static_cast<std::uint32_t>(crc32(0, png.data() + at + 4, static_cast<uInt>(length + 4))));
}

/// x - floor((left + above) / 2), modulo 256.
void filter_row(const std::uint8_t* row, const std::uint8_t* above, int width, std::uint8_t* out) {
  out[0] = static_cast<std::uint8_t>(row[0] - (above[0] >> 1));
  for (int x = 1; x < width; ++x) out[x] = static_cast<std::uint8_t>(row[x] - ((row[x - 1] + above[x]) >> 1));
}

void filter(const ImageView& image, std::vector<std::uint8_t>& filtered) {
  const auto width = static_cast<std::size_t>(image.width);
  filtered.resize((width + 1) * static_cast<std::size_t>(image.height) + width);
  std::uint8_t* const nothing = filtered.data() + filtered.size() - width;  // the row above the first
  std::fill_n(nothing, width, std::uint8_t{0});
  std::uint8_t* out = filtered.data();
  for (int y = 0; y < image.height; ++y, out += width + 1) {
    *out = kAverage;
    filter_row(image.row(y), y > 0 ? image.row(y - 1) : nothing, image.width, out + 1);
  }
  filtered.resize(filtered.size() - width);
}

}  // namespace

struct EncodePng::Stream {
  Stream() {
    if (deflateInit2(&zlib, 1, Z_DEFLATED, MAX_WBITS, MAX_MEM_LEVEL, Z_HUFFMAN_ONLY) != Z_OK) throw std::bad_alloc();
  }
  ~Stream() { deflateEnd(&zlib); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  z_stream zlib{};
};

EncodePng::EncodePng() : stream_(std::make_unique<Stream>()) {}
EncodePng::~EncodePng() = default;
EncodePng::EncodePng(EncodePng&&) noexcept = default;

void EncodePng::operator()(const ImageView& image, std::vector<std::uint8_t>& png) {
  if (image.empty()) throw std::invalid_argument("an empty image cannot be written as PNG");
  filter(image, filtered_);
  static constexpr std::uint8_t kSignature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  png.assign(std::begin(kSignature), std::end(kSignature));
  std::size_t chunk = begin_chunk(png, "IHDR");
  append_big_endian(png, static_cast<std::uint32_t>(image.width));
  append_big_endian(png, static_cast<std::uint32_t>(image.height));
  png.insert(png.end(), {8, 0, 0, 0, 0});  // 8 bits, gray, deflate, the usual filters, not interlaced
  end_chunk(png, chunk);

  chunk = begin_chunk(png, "IDAT");
  z_stream& z = stream_->zlib;
  deflateReset(&z);
  const std::size_t begin = png.size();
  png.resize(begin + deflateBound(&z, static_cast<uLong>(filtered_.size())) + kChunkFrame);
  z.next_in = filtered_.data();
  z.avail_in = static_cast<uInt>(filtered_.size());
  z.next_out = png.data() + begin;
  z.avail_out = static_cast<uInt>(png.size() - begin);
  if (deflate(&z, Z_FINISH) != Z_STREAM_END) throw std::runtime_error("zlib did not compress an image");
  png.resize(begin + z.total_out);
  end_chunk(png, chunk);
  end_chunk(png, begin_chunk(png, "IEND"));
}

}  // namespace pavo
