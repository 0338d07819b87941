// How fast does a camera's frame become gray, beside a memcpy of the bytes that have to be read, and beside
// cv::cvtColor, one thread? First: do all of them show the same picture?
//
//   bench_luma [ROUNDS]      1280x720
#include <hwy/highway.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "bench/fast/picture.h"
#include "stages/decode/decode.h"

namespace pavo::bench {
namespace {

constexpr int kWidth = 1280, kHeight = 720;

struct Format {
  const char* name;
  Encoding encoding;
  int bytes_a_pixel;  ///< that have to be read: of NV12, the driver's luma plane alone is taken over
  int opencv_code;    ///< -1: nothing to convert
};
constexpr Format kFormats[] = {{"YUYV", Encoding::yuyv, 2, cv::COLOR_YUV2GRAY_YUYV},
                               {"UYVY", Encoding::uyvy, 2, cv::COLOR_YUV2GRAY_UYVY},
                               {"NV12, GREY", Encoding::gray8, 1, -1},
                               {"Y16", Encoding::gray16, 2, -1},
                               {"RGB24", Encoding::rgb24, 3, cv::COLOR_RGB2GRAY},
                               {"Bayer RGGB", Encoding::bayer_rggb8, 1, cv::COLOR_BayerBG2GRAY}};

EncodedImage random_frame(const Format& format) {
  std::mt19937 random(1);
  EncodedImage frame{format.encoding, kWidth, kHeight, std::ptrdiff_t{kWidth} * format.bytes_a_pixel, {}};
  frame.bytes.resize(static_cast<std::size_t>(frame.stride * kHeight));
  for (std::uint8_t& byte : frame.bytes) byte = static_cast<std::uint8_t>(random());
  return frame;
}

bool agree(const Image& gray, const cv::Mat& other, int tolerance) {
  for (int y = 1; y + 1 < kHeight; ++y)
    for (int x = 1; x + 1 < kWidth; ++x)
      if (std::abs(gray.at(x, y) - other.at<std::uint8_t>(y, x)) > tolerance) return false;
  return true;
}

bool measure(const Format& format, int rounds) {
  EncodedImage frame = random_frame(format);
  std::vector<std::uint8_t> copy(frame.bytes.size());
  Image gray;
  Decode decode(kWidth, kHeight);
  Decode::Scratch scratch;
  decode(frame, gray, scratch);
  constexpr int kTimes = 10;  // a measurement is long against the clock's own time
  const auto repeated = [](auto work) {
    return [work] {
      for (int n = 0; n < kTimes; ++n) work();
    };
  };
  std::vector<std::function<void()>> competitors{
      repeated([&] { std::memcpy(copy.data(), frame.bytes.data(), copy.size()); }),
      repeated([&] { decode(frame, gray, scratch); })};
  const int type = format.bytes_a_pixel == 1 ? CV_8U : format.bytes_a_pixel == 2 ? CV_8UC2 : CV_8UC3;
  const cv::Mat colour(kHeight, kWidth, type, frame.bytes.data());
  cv::Mat other;
  if (format.opencv_code >= 0) {
    cv::cvtColor(colour, other, format.opencv_code);
    const int tolerance = format.encoding == Encoding::bayer_rggb8 ? 3 : 1;  // 1/64 instead of 1/16384
    if (!agree(gray, other, tolerance)) {
      std::printf("%s: the pictures differ\n", format.name);
      return false;
    }
    competitors.push_back(repeated([&] { cv::cvtColor(colour, other, format.opencv_code); }));
  }
  const std::vector<double> ms = median_ms(rounds, competitors);
  std::printf("%-12s memcpy %7.4f ms   pavo %7.4f ms   memcpy / pavo %5.2f", format.name, ms[0] / kTimes,
              ms[1] / kTimes, ms[0] / ms[1]);
  if (ms.size() > 2) std::printf("   opencv %7.4f ms   opencv / pavo %5.2f", ms[2] / kTimes, ms[2] / ms[1]);
  std::printf("\n");
  return true;
}

}  // namespace
}  // namespace pavo::bench

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 101;
  cv::setNumThreads(1);
  bool same = true;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::GetChosenTarget().Update(target);
    std::printf("%s, 1280x720\n", hwy::TargetName(target));
    for (const auto& format : pavo::bench::kFormats) same &= pavo::bench::measure(format, rounds);
  }
  return same ? 0 : 1;
}
