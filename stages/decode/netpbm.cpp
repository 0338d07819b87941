// PGM and PPM: a header of numbers, then samples as numbers (P2, P3) or as bytes (P5, P6).
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>

#include "stages/decode/formats.h"

namespace pavo::decode_detail {
namespace {

bool is_space(std::uint8_t c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}
bool is_digit(std::uint8_t c) {
  return c >= '0' && c <= '9';
}

class NetpbmReader {
 public:
  NetpbmReader(Bytes bytes, std::size_t at) : bytes_(bytes), at_(at) {}

  /// The next number, behind spaces and comments. Throws when there is none, or it is above 2^31 - 1.
  int number(const char* what) {
    skip_space();
    std::int64_t value = 0;
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && is_digit(bytes_[at_])) {
      value = value * 10 + (bytes_[at_++] - '0');
      if (value > 0x7FFFFFFF) throw std::runtime_error(std::string("PGM/PPM: the ") + what + " is too large");
    }
    if (at_ == begin)
      throw std::runtime_error(std::string("PGM/PPM: expected the ") + what + " at byte " + std::to_string(at_));
    return static_cast<int>(value);
  }

  /// Exactly one space is between the header and the bytes.
  Bytes bytes_behind_space() {
    if (at_ >= bytes_.size() || !is_space(bytes_[at_]))
      throw std::runtime_error("PGM/PPM: premature end of the header");
    return bytes_.subspan(at_ + 1);
  }

 private:
  void skip_space() {
    while (at_ < bytes_.size()) {
      if (bytes_[at_] == '#') {
        while (at_ < bytes_.size() && bytes_[at_] != '\n') ++at_;
      } else if (is_space(bytes_[at_])) {
        ++at_;
      } else {
        return;
      }
    }
  }

  Bytes bytes_;
  std::size_t at_;
};

struct Header {
  int width = 0, height = 0, largest = 0;
  bool ascii = false, colour = false;
  std::size_t samples() const { return static_cast<std::size_t>(width) * (colour ? 3U : 1U); }
};

/// Of 16-bit samples the upper 8 bits; smaller ranges than 8 bits are spread over 0 to 255.
std::uint8_t to_8_bits(int value, int largest) {
  if (value > largest) throw std::runtime_error("PGM/PPM: a sample is above the largest value that the header tells");
  if (largest == 255) return static_cast<std::uint8_t>(value);
  if (largest > 255) return static_cast<std::uint8_t>(value >> 8);
  return static_cast<std::uint8_t>((value * 255 + largest / 2) / largest);
}

void put(const Header& header, const std::uint8_t* samples, std::uint8_t* out) {
  if (header.colour) return luma_of_rgb(samples, header.width, out);
  std::memcpy(out, samples, static_cast<std::size_t>(header.width));
}

void read_binary(const Header& header, Bytes data, Image& out) {
  const std::size_t sample_bytes = header.largest > 255 ? 2 : 1;
  const std::size_t row_bytes = header.samples() * sample_bytes;
  if (data.size() / row_bytes < static_cast<std::size_t>(header.height))
    throw std::runtime_error("PGM/PPM: premature end of the file");
  out.resize(header.width, header.height);
  std::vector<std::uint8_t> row(header.largest == 255 ? 0 : header.samples());
  for (int y = 0; y < header.height; ++y, data = data.subspan(row_bytes)) {
    if (header.largest == 255) {
      put(header, data.data(), out.row(y));
      continue;
    }
    for (std::size_t i = 0; i < row.size(); ++i)
      row[i] = to_8_bits(sample_bytes == 1 ? data[i] : data[2 * i] << 8 | data[2 * i + 1], header.largest);
    put(header, row.data(), out.row(y));
  }
}

void read_ascii(const Header& header, NetpbmReader& reader, std::size_t bytes, Image& out) {
  if (header.samples() > bytes / static_cast<std::size_t>(header.height))  // a sample is a digit at least
    throw std::runtime_error("PGM/PPM: premature end of the file");
  out.resize(header.width, header.height);
  std::vector<std::uint8_t> row(header.samples());
  for (int y = 0; y < header.height; ++y) {
    for (std::uint8_t& sample : row) sample = to_8_bits(reader.number("next sample"), header.largest);
    put(header, row.data(), out.row(y));
  }
}

}  // namespace

bool is_netpbm(Bytes b) {
  return b.size() >= 3 && b[0] == 'P' && (b[1] == '2' || b[1] == '3' || b[1] == '5' || b[1] == '6') &&
         (is_space(b[2]) || b[2] == '#');
}

void decode_netpbm(Bytes bytes, const SizeCheck& check_size, Image& out) {
  Header header;
  header.ascii = bytes[1] == '2' || bytes[1] == '3';
  header.colour = bytes[1] == '3' || bytes[1] == '6';
  NetpbmReader reader(bytes, 2);
  header.width = reader.number("width");
  header.height = reader.number("height");
  header.largest = reader.number("largest value");
  check_size(header.width, header.height);
  if (header.largest < 1 || header.largest > 65535)
    throw std::runtime_error("PGM/PPM: the largest value is " + std::to_string(header.largest) +
                             "; expected 1 to 65535");
  if (header.ascii) return read_ascii(header, reader, bytes.size(), out);
  read_binary(header, reader.bytes_behind_space(), out);
}

}  // namespace pavo::decode_detail
