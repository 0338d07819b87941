#include "drivers/sequences/image_size.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace pavo {
namespace {

constexpr int kWidth = 11, kHeight = 9;

/// One of the fuzzer's seeds: OpenCV wrote them, each 11x9.
std::vector<std::uint8_t> seed(const std::string& name) {
  std::ifstream file(std::filesystem::path(PAVO_SOURCE_DIR) / "tests" / "fuzz" / "corpus" / "image_size" / name,
                     std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(ImageSize, OfEveryKindOfFile) {
  for (const char* name : {"gray_png", "colour_png", "gray16_png", "gray_jpg", "colour_jpg", "progressive_jpg",
                           "gray_pgm", "colour_ppm", "ascii_pgm", "gray16_pgm", "bmp", "tiff"}) {
    const auto size = image_size(seed(name));
    ASSERT_TRUE(size) << name;
    EXPECT_EQ(size->width, kWidth) << name;
    EXPECT_EQ(size->height, kHeight) << name;
  }
}

TEST(ImageSize, AHeaderIsEnough) {
  for (const char* name : {"gray_png", "gray_pgm", "bmp", "colour_jpg"}) {
    auto bytes = seed(name);
    bytes.resize(bytes.size() * 3 / 4);
    const auto size = image_size(bytes);
    ASSERT_TRUE(size) << name;
    EXPECT_EQ(size->width, kWidth) << name;
  }
}

TEST(ImageSize, OfABitmapThatGoesDownwards) {
  auto bytes = seed("bmp");
  for (std::size_t i = 22; i < 26; ++i) bytes[i] = i == 22 ? static_cast<std::uint8_t>(-kHeight) : 0xff;
  ASSERT_TRUE(image_size(bytes));
  EXPECT_EQ(image_size(bytes)->height, kHeight);
}

TEST(ImageSize, NothingInWhatIsNone) {
  EXPECT_FALSE(image_size({}));
  const std::string texts[] = {"garbage",
                               "\x89PNG\r\n\x1a\n",
                               "\xff\xd8\xff",
                               "\xff\xd8\xff\xe0\xff",
                               "P5",
                               "P5 #",
                               "P5 # \n 5",
                               "P5 99999999999 5",
                               "\xff\xd8\xff\xff\xff\xff",
                               "BM",
                               std::string("II*\0\xff\xff\xff\xff", 8),
                               std::string("MM\0*\0\0\0\x8", 8)};
  for (const std::string& text : texts) {
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    EXPECT_FALSE(image_size(bytes)) << text;
  }
}

}  // namespace
}  // namespace pavo
