#include "stages/decode/decode.h"
#include "tests/fuzz/fuzz.h"

/// The bytes of a file; a picture of more than a few thousand pixels only takes time. (Uncompressed frames never come
/// from a file.)
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace pavo;
  static const Decode decode;
  static Decode::Scratch scratch;
  static Image raw;
  EncodedImage encoded;
  encoded.bytes.assign(data, data + size);
  try {
    decode(encoded, raw, scratch);
    std::uint64_t sum = 0;
    for (int y = 0; y < raw.height(); ++y) {
      for (int x = 0; x < raw.width(); ++x) sum += raw.at(x, y);
    }
    fuzz::require(raw.width() > 0 && raw.height() > 0, "a decoded image has pixels");
    fuzz::require(sum <= 255 * static_cast<std::uint64_t>(Decode::kMaxPixels), "all of them readable");
  } catch (const std::runtime_error& error) {
    const std::string message = error.what();
    fuzz::require(!message.empty() && message.find('\n') == std::string::npos, "an error is one line");
  }
  return 0;
}
