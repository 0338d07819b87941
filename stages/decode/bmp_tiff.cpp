// BMP and TIFF are OpenCV's to decode. Before that, the header is read here: for the size, so that no memory is taken
// for what is not wanted, and for whether the file is whole, which OpenCV does not always say.
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>

#include "stages/decode/formats.h"

namespace pavo::decode_detail {
namespace {

/// Reads numbers of one byte order, and nothing outside the bytes.
class Numbers {
 public:
  Numbers(Bytes bytes, bool big_endian, const char* format) : bytes_(bytes), big_endian_(big_endian), format_(format) {}

  std::uint32_t u16(std::size_t at) const { return number(at, 2); }
  std::uint32_t u32(std::size_t at) const { return number(at, 4); }

 private:
  std::uint32_t number(std::size_t at, std::size_t size) const {
    if (at > bytes_.size() || bytes_.size() - at < size)
      throw std::runtime_error(std::string(format_) + ": premature end of the file");
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t shift = 8 * (big_endian_ ? size - 1 - i : i);
      value |= static_cast<std::uint32_t>(bytes_[at + i]) << shift;
    }
    return value;
  }

  Bytes bytes_;
  bool big_endian_;
  const char* format_;
};

void decode_by_opencv(Bytes bytes, const char* format, const SizeCheck& check_size, Image& out) {
  // OpenCV only reads from it.
  const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<std::uint8_t*>(bytes.data()));
  cv::Mat decoded;
  try {
    decoded = cv::imdecode(encoded, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& error) {
    throw std::runtime_error(std::string(format) + ": OpenCV cannot decode it: " + error.err);
  }
  if (decoded.empty()) throw std::runtime_error(std::string(format) + ": corrupt or truncated data");
  check_size(decoded.cols, decoded.rows);
  if (decoded.channels() != 1 || (decoded.depth() != CV_8U && decoded.depth() != CV_16U))
    throw std::runtime_error(std::string(format) + ": expected samples of 8 or 16 bits");
  out.resize(decoded.cols, decoded.rows);
  for (int y = 0; y < decoded.rows; ++y) {
    if (decoded.depth() == CV_8U) {
      std::memcpy(out.row(y), decoded.ptr(y), static_cast<std::size_t>(decoded.cols));
      continue;
    }
    const auto* wide = decoded.ptr<std::uint16_t>(y);
    for (int x = 0; x < decoded.cols; ++x) out.at(x, y) = static_cast<std::uint8_t>(wide[x] >> 8);
  }
}

void require_file_size(Bytes bytes, const char* format) {
  if (bytes.size() > 0x7FFFFFFF) throw std::runtime_error(std::string(format) + ": the file is larger than 2 GB");
}

}  // namespace

bool is_bmp(Bytes b) {
  return b.size() >= 2 && b[0] == 'B' && b[1] == 'M';
}

bool is_tiff(Bytes b) {
  return b.size() >= 4 && (std::memcmp(b.data(), "II*\0", 4) == 0 || std::memcmp(b.data(), "MM\0*", 4) == 0);
}

void decode_bmp(Bytes bytes, const SizeCheck& check_size, Image& out) {
  require_file_size(bytes, "BMP");
  const Numbers numbers(bytes, false, "BMP");
  const std::int64_t pixels_at = numbers.u32(10);
  if (numbers.u32(14) < 40) throw std::runtime_error("BMP: the header is of OS/2, which is not supported");
  const auto width = static_cast<std::int32_t>(numbers.u32(18));
  const std::int64_t signed_height = static_cast<std::int32_t>(numbers.u32(22));
  const std::int64_t height = signed_height < 0 ? -signed_height : signed_height;  // below 0: from the top down
  const std::int64_t bits = numbers.u16(28);
  const std::uint32_t compression = numbers.u32(30);
  check_size(width, height);
  if (bits > 32) throw std::runtime_error("BMP: " + std::to_string(bits) + " bits a pixel; expected up to 32");
  if (compression != 0 && compression != 3) throw std::runtime_error("BMP: compressed data is not supported");
  const std::int64_t row_bytes = (width * bits + 31) / 32 * 4;
  if (pixels_at + row_bytes * height > static_cast<std::int64_t>(bytes.size()))
    throw std::runtime_error("BMP: premature end of the file");
  decode_by_opencv(bytes, "BMP", check_size, out);
}

void decode_tiff(Bytes bytes, const SizeCheck& check_size, Image& out) {
  require_file_size(bytes, "TIFF");
  const Numbers numbers(bytes, bytes[0] == 'M', "TIFF");
  const std::size_t directory = numbers.u32(4);
  const std::size_t entries = numbers.u16(directory);
  std::int64_t width = 0, height = 0;
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t at = directory + 2 + 12 * i;
    const std::uint32_t tag = numbers.u16(at), type = numbers.u16(at + 2);
    if (tag != 256 && tag != 257) continue;  // ImageWidth, ImageLength: 3 = 16 bits, 4 = 32 bits
    if (type != 3 && type != 4) throw std::runtime_error("TIFF: the image's size has an unexpected type");
    (tag == 256 ? width : height) = type == 3 ? numbers.u16(at + 8) : numbers.u32(at + 8);
  }
  check_size(width, height);
  decode_by_opencv(bytes, "TIFF", check_size, out);
}

}  // namespace pavo::decode_detail
