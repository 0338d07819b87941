// What webcams make of JPEG: tables left out, filled up in front of the end's marker.
#include "tests/decode/files.h"

namespace pavo::test {
namespace {

std::string error_of(const Bytes& bytes) {
  try {
    decode(file_of(bytes));
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

Bytes webcam_jpeg() {
  return encode(".jpg", picture(160, 120, CV_8UC1));
}

TEST(WebcamJpeg, FilledUpBeforeItsEndIsTheWholePicture) {
  const Bytes bytes = webcam_jpeg();
  const cv::Mat expected = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
  for (const std::uint8_t filling : {std::uint8_t{0}, std::uint8_t{0x5A}})
    for (std::size_t count = 0; count <= 60; ++count) {
      Bytes filled = bytes;
      filled.insert(filled.end() - 2, count, filling);
      filled.insert(filled.end(), 100, 0);  // and behind it
      EXPECT_LE(largest_difference(decode(file_of(filled)), expected), 1) << count;
    }
}

TEST(WebcamJpeg, FilledUpWithMoreThanFillingIsAnError) {
  Bytes bytes = webcam_jpeg();
  bytes.insert(bytes.end() - 2, 200, 0x5A);
  EXPECT_NE(error_of(bytes).find("extraneous"), std::string::npos);
}

TEST(WebcamJpeg, WithAHoleIsNoBetterWhenItIsFilled) {
  int found = 0;
  const Bytes bytes = encode(".jpg", picture(160, 120, CV_8UC1), {cv::IMWRITE_JPEG_RST_INTERVAL, 10});
  for (std::size_t missing = 20; missing <= 60; missing += 10) {
    Bytes holed = bytes;
    holed.erase(holed.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2),
                holed.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2 + missing));
    Bytes filled = holed;
    filled.insert(filled.end() - 2, missing, 0);
    EXPECT_EQ(error_of(holed).empty(), error_of(filled).empty()) << missing;
    found += !error_of(filled).empty();
  }
  EXPECT_GE(found, 3);  // libjpeg does not see every hole
}

// Motion-JPEG leaves out the tables of the standard's annex K.
TEST(WebcamJpeg, WithoutHuffmanTablesHasTheStandardOnes) {
  Bytes bytes = webcam_jpeg();
  const cv::Mat expected = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
  const auto at = [&](std::size_t i) { return static_cast<std::ptrdiff_t>(i); };
  std::size_t removed = 0;
  for (std::size_t i = 2; i + 3 < bytes.size() && bytes[i] == 0xFF && bytes[i + 1] != 0xDA;) {
    const std::size_t length = 2u + 256u * bytes[i + 2] + bytes[i + 3];
    if (bytes[i + 1] == 0xC4) {
      bytes.erase(bytes.begin() + at(i), bytes.begin() + at(i + length));
      ++removed;
    } else {
      i += length;
    }
  }
  ASSERT_GT(removed, 0u);
  EXPECT_LE(largest_difference(decode(file_of(bytes)), expected), 1);
}

}  // namespace
}  // namespace pavo::test
