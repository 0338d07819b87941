#include <gtest/gtest.h>

#include <random>

#include "tests/decode/files.h"

namespace pavo::test {
namespace {

struct Sample {
  std::string name;
  Bytes bytes;
};

std::vector<Sample> samples() {
  const cv::Mat gray = picture(37, 23, CV_8UC1), colour = picture(37, 23, CV_8UC3);
  return {
      {"gray JPEG", encode(".jpg", gray)},
      {"colour JPEG", encode(".jpg", colour)},
      {"progressive JPEG", encode(".jpg", colour, {cv::IMWRITE_JPEG_PROGRESSIVE, 1})},
      {"JPEG with restarts", encode(".jpg", gray, {cv::IMWRITE_JPEG_RST_INTERVAL, 2})},
      {"gray PNG", encode(".png", gray)},
      {"colour PNG", encode(".png", colour)},
      {"16-bit PNG", encode(".png", picture(37, 23, CV_16UC1))},
      {"PGM", encode(".pgm", gray)},
      {"16-bit PGM", encode(".pgm", picture(37, 23, CV_16UC1))},
      {"PPM", encode(".ppm", colour)},
      {"BMP", encode(".bmp", colour)},
      {"TIFF", encode(".tiff", gray)},
      {"TIFF, uncompressed", encode(".tiff", gray, {cv::IMWRITE_TIFF_COMPRESSION, 1})},
  };
}

/// Cut off anywhere, a file is an error, or it is still the whole picture: never a part of it.
TEST(TruncatedFile, IsAnErrorOrTheWholePicture) {
  for (const auto& [name, bytes] : samples()) {
    const cv::Mat expected = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
    for (std::size_t cut = 0; cut < bytes.size(); ++cut) {
      const EncodedImage part = file_of(std::span(bytes).first(cut));
      try {
        const Image image = decode(part);
        EXPECT_LE(largest_difference(image, expected), 1) << name << " cut at " << cut << " of " << bytes.size();
        EXPECT_GT(cut, bytes.size() - 16) << name << ": so much cannot be padding";
      } catch (const std::runtime_error& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << name << ": " << error.what();
      }
    }
  }
}

TEST(TruncatedFile, OfJpegAndPngIsAlwaysAnError) {
  for (const auto& [name, bytes] : samples()) {
    if (name.find("JPEG") == std::string::npos && name.find("PNG") == std::string::npos) continue;
    for (std::size_t cut = 0; cut < bytes.size(); ++cut)
      EXPECT_NE(error_of(file_of(std::span(bytes).first(cut))), "") << name << " cut at " << cut;
  }
}

TEST(PaddedFile, IsTheSamePicture) {
  for (auto [name, bytes] : samples()) {
    const cv::Mat expected = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
    bytes.insert(bytes.end(), 100, 0);
    EXPECT_LE(largest_difference(decode(file_of(bytes)), expected), 1) << name;
  }
}

/// A changed byte may give another picture where the format has no checksum, but never a crash; in PNG it always shows.
TEST(CorruptFile, NeverCrashes) {
  std::mt19937 random(1);
  for (const auto& [name, bytes] : samples())
    for (int n = 0; n < 300; ++n) {
      Bytes corrupt = bytes;
      const std::size_t changes = 1 + random() % 4;
      for (std::size_t c = 0; c < changes; ++c)
        corrupt[random() % corrupt.size()] = static_cast<std::uint8_t>(random());
      const std::string error = error_of(file_of(corrupt), 37, 23);
      EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    }
}

TEST(CorruptFile, OfPngIsAlwaysAnErrorOrTheWholePicture) {
  const Bytes bytes = encode(".png", picture(37, 23, CV_8UC1));
  const cv::Mat expected = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    Bytes corrupt = bytes;
    corrupt[at] ^= 0x10;
    try {
      EXPECT_EQ(largest_difference(decode(file_of(corrupt)), expected), 0) << at;
    } catch (const std::runtime_error&) {
    }
  }
}

TEST(CorruptFile, WhatLibjpegOnlyWarnsAboutIsAnError) {
  const Bytes bytes = encode(".jpg", picture(160, 120, CV_8UC1));
  Bytes holed = bytes;  // a hole in the coded data, whose rest is intact
  holed.erase(holed.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2),
              holed.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2 + 200));
  EXPECT_NE(error_of(file_of(holed)), "");
  Bytes without_end(bytes.begin(), bytes.end() - 2);
  EXPECT_NE(error_of(file_of(without_end)).find("JPEG"), std::string::npos);
}

TEST(UnknownFile, IsAnErrorThatSaysWhatWasExpected) {
  EXPECT_NE(error_of(file_of({})), "");
  const std::string text = "this is no image at all";
  const std::string error = error_of(file_of(Bytes(text.begin(), text.end())));
  EXPECT_NE(error.find("expected JPEG, PNG"), std::string::npos) << error;
  std::mt19937 random(2);
  for (int n = 0; n < 200; ++n) {
    Bytes noise(random() % 300);
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(random());
    EXPECT_NE(error_of(file_of(noise)), "");
  }
}

TEST(FrameOfAnotherSize, IsAnErrorThatNamesBothSizes) {
  for (const auto& [name, bytes] : samples()) {
    const std::string error = error_of(file_of(bytes), 37, 24);
    EXPECT_NE(error.find("37x23"), std::string::npos) << name << ": " << error;
    EXPECT_NE(error.find("37x24"), std::string::npos) << name << ": " << error;
    EXPECT_EQ(error_of(file_of(bytes), 37, 23), "") << name;
    EXPECT_EQ(error_of(file_of(bytes), 0, 23), "") << name;
    EXPECT_NE(error_of(file_of(bytes), 38, 0), "") << name;
  }
  EXPECT_NE(error_of({Encoding::gray8, 2, 2, 2, Bytes(4)}, 2, 3), "");
  EXPECT_THROW(Decode(-1, 2), std::invalid_argument);
}

TEST(UncompressedFrame, WithTooFewBytesIsAnError) {
  EXPECT_EQ(error_of({Encoding::gray8, 4, 3, 6, Bytes(16)}), "");
  EXPECT_NE(error_of({Encoding::gray8, 4, 3, 6, Bytes(15)}), "");
  EXPECT_NE(error_of({Encoding::gray8, 4, 3, 3, Bytes(100)}), "");
  EXPECT_NE(error_of({Encoding::gray8, 4, 3, -6, Bytes(100)}), "");
  EXPECT_EQ(error_of({Encoding::bgr24, 4, 3, 12, Bytes(36)}), "");
  EXPECT_NE(error_of({Encoding::bgr24, 4, 3, 12, Bytes(35)}), "");
  EXPECT_NE(error_of({Encoding::bgr24, 4, 3, 11, Bytes(100)}), "");
  EXPECT_NE(error_of({Encoding::gray8, 0, 3, 6, Bytes(15)}), "");
  EXPECT_NE(error_of({Encoding::gray8, 4, -3, 6, Bytes(15)}), "");
  EXPECT_NE(error_of({Encoding::gray8, 4, 3, 6, {}}), "");
}

/// A few bytes that promise a huge picture: refused by its header, before memory is taken.
TEST(HugePicture, IsRefusedBeforeItIsAllocated) {
  const auto refused = [](const Bytes& bytes) {
    return error_of(file_of(bytes)).find("64 megapixels") != std::string::npos;
  };
  const auto text = [](const std::string& s) { return Bytes(s.begin(), s.end()); };
  EXPECT_TRUE(refused(text("P5 100000 100000 255\nabc")));
  EXPECT_TRUE(refused(text("P2 2147483647 2147483647 255\n1 2 3")));
  EXPECT_NE(error_of(file_of(text("P5 99999999999999999999 1 255\n"))), "");

  Bytes jpeg = encode(".jpg", picture(16, 16, CV_8UC1));
  for (std::size_t i = 0; i + 8 < jpeg.size(); ++i)
    if (jpeg[i] == 0xFF && jpeg[i + 1] == 0xC0) jpeg[i + 5] = jpeg[i + 7] = 0xF0;  // 61456 x 61456
  EXPECT_TRUE(refused(jpeg));

  Bytes bmp = encode(".bmp", picture(16, 16, CV_8UC1));
  bmp[20] = bmp[24] = 1;  // 65552 x 65552
  EXPECT_TRUE(refused(bmp));

  const std::uint8_t tiff[] = {'I', 'I', '*', 0, 8, 0, 0, 0, 2, 0, 0, 1, 4, 0, 1, 0, 0, 0, 0,
                               0,   1,   0,   1, 1, 4, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0};
  EXPECT_TRUE(refused(Bytes(std::begin(tiff), std::end(tiff))));
}

TEST(HugePicture, OfPngIsRefused) {
  const std::uint8_t header[] = {0x89, 'P', 'N', 'G', 0x0D, 0x0A, 0x1A, 0x0A, 0, 0, 0, 13, 'I',  'H',  'D',  'R', 0,
                                 1,    0,   0,   0,   1,    0,    0,    8,    0, 0, 0, 0,  0xB8, 0xB5, 0xF2, 0xBB};
  EXPECT_NE(error_of(file_of(header)), "");  // whether its checksum is right or not
}

TEST(Scratch, WorksOnAfterAnError) {
  const Bytes jpeg = encode(".jpg", picture(37, 23, CV_8UC1)), png = encode(".png", picture(37, 23, CV_8UC1));
  Decode::Scratch scratch;
  const Decode decode_frame;
  Image image;
  for (const Bytes& bytes : {jpeg, png, jpeg}) {
    EXPECT_THROW(decode_frame(file_of(std::span(bytes).first(bytes.size() / 2)), image, scratch), std::runtime_error);
    decode_frame(file_of(bytes), image, scratch);
    EXPECT_LE(largest_difference(image, cv::imdecode(bytes, cv::IMREAD_GRAYSCALE)), 1);
  }
  Decode::Scratch moved = std::move(scratch);
  decode_frame(file_of(jpeg), image, moved);
}

}  // namespace
}  // namespace pavo::test
