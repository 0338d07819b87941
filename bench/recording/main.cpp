// Does recording keep up? Frames of the synthetic street, rendered before, come at a camera's pace; and what a frame
// costs as PNG, ours beside OpenCV's, whose pixels are compared first.
//
//   bench_recording [FOLDER] [RATE_HZ] [SECONDS]
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <thread>
#include <vector>

#include "drivers/recording/encode_png.h"
#include "drivers/recording/sequence_recorder.h"
#include "drivers/synthetic/synthetic_street.h"

namespace {

using Bytes = std::vector<std::uint8_t>;
using Clock = std::chrono::steady_clock;

double cpu_ms(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

std::vector<pavo::EncodedImage> street() {
  pavo::SyntheticOptions options;
  options.width = 640, options.height = 480, options.frames = 12, options.noise_sigma = 2;
  pavo::SyntheticStreet source(options);
  std::vector<pavo::EncodedImage> frames;
  pavo::EncodedImage image;
  pavo::FrameStamp stamp;
  while (source.read(image, stamp)) frames.push_back(image);
  return frames;
}

pavo::ImageView view_of(const pavo::EncodedImage& frame) {
  return {frame.bytes.data(), frame.width, frame.height, frame.stride};
}

cv::Mat mat_of(const pavo::EncodedImage& frame) {
  return {frame.height, frame.width, CV_8UC1, const_cast<std::uint8_t*>(frame.bytes.data()),
          static_cast<std::size_t>(frame.stride)};
}

template <typename Encode>
void report(const char* name, const std::vector<pavo::EncodedImage>& frames, Encode encode) {
  std::vector<double> ms;
  std::size_t bytes = 0;
  Bytes file;
  for (int round = 0; round < 5; ++round)
    for (const pavo::EncodedImage& frame : frames) {
      const double start = cpu_ms(CLOCK_THREAD_CPUTIME_ID);
      encode(frame, file);
      ms.push_back(cpu_ms(CLOCK_THREAD_CPUTIME_ID) - start);
      bytes += file.size();
    }
  std::nth_element(ms.begin(), ms.begin() + static_cast<std::ptrdiff_t>(ms.size() / 2), ms.end());
  std::printf("  %-28s %6.2f ms a frame (median, CPU), %zu bytes\n", name, ms[ms.size() / 2], bytes / ms.size());
}

void compare_encoders(const std::vector<pavo::EncodedImage>& frames) {
  pavo::EncodePng encode;
  Bytes file;
  for (const pavo::EncodedImage& frame : frames) {
    encode(view_of(frame), file);
    if (cv::norm(cv::imdecode(file, cv::IMREAD_UNCHANGED), mat_of(frame), cv::NORM_INF) != 0) {
      std::fprintf(stderr, "bench_recording: the PNG has other pixels\n");
      std::exit(1);
    }
  }
  std::printf("640x480 gray as PNG:\n");
  report("pavo", frames, [&](const pavo::EncodedImage& f, Bytes& out) { encode(view_of(f), out); });
  for (const int level : {1, 3})
    report(("OpenCV, compression " + std::to_string(level)).c_str(), frames,
           [&](const pavo::EncodedImage& f, Bytes& out) {
             cv::imencode(".png", mat_of(f), out, {cv::IMWRITE_PNG_COMPRESSION, level});
           });
}

void record(const std::vector<pavo::EncodedImage>& frames, const std::string& folder, double rate_hz, double seconds) {
  std::filesystem::remove_all(folder);
  pavo::SequenceRecorder recorder(folder, {.encoders = 2}, [] {
    return [e = std::make_shared<pavo::EncodePng>()](const pavo::EncodedImage& f, Bytes& out) -> std::string_view {
      (*e)(view_of(f), out);
      return ".png";
    };
  });
  const double cpu_start = cpu_ms(CLOCK_PROCESS_CPUTIME_ID);
  const auto start = Clock::now();
  const auto count = static_cast<std::int64_t>(rate_hz * seconds);
  double longest_offer_ms = 0;
  pavo::EncodedImage image;
  for (std::int64_t i = 0; i < count; ++i) {
    const auto t = std::chrono::nanoseconds(static_cast<std::int64_t>(static_cast<double>(i) * 1e9 / rate_hz));
    std::this_thread::sleep_until(start + t);
    const auto before = Clock::now();
    image = frames[static_cast<std::size_t>(i) % frames.size()];
    recorder.offer(image, t.count() + 1);
    longest_offer_ms =
        std::max(longest_offer_ms, std::chrono::duration<double, std::milli>(Clock::now() - before).count());
  }
  recorder.finish();
  const double cpu = cpu_ms(CLOCK_PROCESS_CPUTIME_ID) - cpu_start;
  const pavo::RecordCounts c = recorder.counts();
  std::printf("recording at %.0f Hz for %.0f s: %llu offered, %llu written, %llu without room; %.1f MB/s\n", rate_hz,
              seconds, static_cast<unsigned long long>(c.offered), static_cast<unsigned long long>(c.written),
              static_cast<unsigned long long>(c.no_room), static_cast<double>(c.bytes) / seconds * 1e-6);
  std::printf("  %.2f ms CPU a frame in all, %.0f %% of one core; the longest offer(), with a copy: %.2f ms\n",
              cpu / static_cast<double>(count), cpu / seconds / 10, longest_offer_ms);
  std::filesystem::remove_all(folder);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string folder =
      argc > 1 ? argv[1] : (std::filesystem::temp_directory_path() / "pavo-bench-recording").string();
  const std::vector<pavo::EncodedImage> frames = street();
  compare_encoders(frames);
  record(frames, folder, argc > 2 ? std::atof(argv[2]) : 60, argc > 3 ? std::atof(argv[3]) : 10);
}
