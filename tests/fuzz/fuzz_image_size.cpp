#include "drivers/sequences/image_size.h"
#include "tests/fuzz/fuzz.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (const auto found = pavo::image_size({data, size})) {
    pavo::fuzz::require(found->width > 0 && found->height > 0, "an image has a size");
    pavo::fuzz::require(found->width <= 65535 && found->height <= 65535, "and one that fits");
  }
  return 0;
}
