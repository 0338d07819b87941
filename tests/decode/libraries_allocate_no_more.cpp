// Decoding is where a frame's way allocates: libpng and libjpeg-turbo do, a fixed number of times a picture, and our
// own part not at all. Counted are all calls of malloc, over 500 pictures of different contents.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "stages/decode/decode.h"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && defined(__GLIBC__)

namespace {
std::atomic<bool> counting{false};
std::atomic<long> mallocs{0};
}  // namespace

extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) {
  if (counting.load(std::memory_order_relaxed)) mallocs.fetch_add(1, std::memory_order_relaxed);
  return __libc_malloc(size);
}

namespace pavo::test {
namespace {

std::vector<EncodedImage> pictures(const char* format) {
  std::vector<EncodedImage> all;
  cv::RNG random(7);
  for (int k = 0; k < 10; ++k) {
    cv::Mat noise(96, 320, CV_8UC1), smooth;
    random.fill(noise, cv::RNG::UNIFORM, 0, 256);
    cv::blur(noise, smooth, {k + 1, k + 1});
    EncodedImage& picture = all.emplace_back();
    std::vector<std::uint8_t> bytes;
    cv::imencode(format, smooth, bytes);
    picture.bytes.assign(bytes.begin(), bytes.end());
  }
  return all;
}

long mallocs_of(const std::vector<EncodedImage>& pictures, int count) {
  const Decode decode(320, 96);
  Decode::Scratch scratch;
  Image image;
  for (const EncodedImage& picture : pictures) decode(picture, image, scratch);
  mallocs = 0;
  counting = true;
  for (int i = 0; i < count; ++i) decode(pictures[static_cast<std::size_t>(i) % pictures.size()], image, scratch);
  counting = false;
  return mallocs;
}

// libpng 1.6 with zlib 1.2, libjpeg-turbo 2.1: Debian 12's.
constexpr long kOfPng = 7, kOfJpeg = 5;

TEST(Decoding, AllocatesAFixedNumberOfTimesInItsLibraries) {
  EXPECT_LE(mallocs_of(pictures(".png"), 500), 500 * kOfPng);
  EXPECT_LE(mallocs_of(pictures(".jpg"), 500), 500 * kOfJpeg);
}

}  // namespace
}  // namespace pavo::test

#endif
