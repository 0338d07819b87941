// Do memory and time stay what they are, however long the drive? A closed street, rendered once and driven round and
// round through the keyframe estimator.
//
//   bench_endurance [--frames 20000] [--size 320x96] [--every 2000]
//
// Prints a line every so many frames: resident memory, what is allocated, and the CPU time of a frame and a keyframe
// (median and 99th percentile of these frames).
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <opencv2/core/utility.hpp>
#include <string>
#include <vector>

#include "drivers/synthetic/synthetic_street.h"
#include "pavo/plain_loop.h"
#include "stages/decode/decode.h"

namespace pavo::bench {
namespace {

struct Call {
  int frames = 20000, width = 320, height = 96, every = 2000;
};

struct Round {
  Camera camera;
  std::vector<Image> images;
};

// One time round: until the camera is back where it was.
Round render(const Call& call) {
  SyntheticOptions street;
  street.loop = true;
  street.frames = 1000;
  street.width = call.width, street.height = call.height;
  street.people = false;
  SyntheticStreet sequence(street);
  const Trajectory& truth = *sequence.info().groundtruth;
  std::size_t round = 100;
  while (round + 1 < truth.T_w_c.size() && truth.T_w_c[round].t.norm() > 1.01 * truth.T_w_c[1].t.norm()) ++round;
  const Decode decode(call.width, call.height);
  Decode::Scratch scratch;
  EncodedImage encoded;
  Round made{.camera = *sequence.info().camera, .images = std::vector<Image>(round)};
  FrameStamp stamp;
  for (Image& image : made.images) {
    sequence.read(encoded, stamp);
    decode(encoded, image, scratch);
  }
  return made;
}

double resident_mb() {
  std::ifstream statm("/proc/self/statm");
  double size = 0, resident = 0;
  statm >> size >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

double allocated_mb() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / 1e6;
}

double percentile(std::vector<double>& v, double share) {
  if (v.empty()) return 0;
  const auto place = v.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(v.size() - 1));
  std::nth_element(v.begin(), place, v.end());
  return *place;
}

void drive(const Call& call) {
  const Round round = render(call);
  std::fprintf(stderr, "%zu frames are once round\n", round.images.size());
  PlainLoopOptions options;
  options.map.ground.emplace();
  options.map.ground->filter.height_m = 1.65;
  PlainLoop loop(round.camera, options, std::make_shared<UnknownStep>());
  std::vector<double> odometry, map;
  int keyframes = 0, without = 0;
  std::printf(
      "| frames | resident MB | allocated MB | odometry p50 / p99 ms | map p50 / p99 ms | keyframes | no pose |\n");
  std::printf("| --- | --- | --- | --- | --- | --- | --- |\n");
  for (int k = 0; k < call.frames; ++k) {
    const Image& image = round.images[static_cast<std::size_t>(k) % round.images.size()];
    const PoseResult& pose = loop({.index = k, .t_ns = 100'000'000LL * k}, image, {});
    odometry.push_back(loop.odometry_ms());
    if (loop.record().is_keyframe) map.push_back(loop.map_ms()), ++keyframes;
    without += pose.quality == Quality::coasting || pose.quality == Quality::relocalising;
    if ((k + 1) % call.every != 0) continue;
    const double o50 = percentile(odometry, 0.5), o99 = percentile(odometry, 0.99);
    const double m50 = percentile(map, 0.5), m99 = percentile(map, 0.99);
    std::printf("| %d | %.1f | %.2f | %.2f / %.2f | %.2f / %.2f | %d | %d |\n", k + 1, resident_mb(), allocated_mb(),
                o50, o99, m50, m99, keyframes, without);
    std::fflush(stdout);
    odometry.clear(), map.clear();
    keyframes = without = 0;
  }
}

int run(int argc, char** argv) {
  cv::setNumThreads(1);
  Call call;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string word = argv[i];
    if (word == "--frames")
      call.frames = std::atoi(argv[i + 1]);
    else if (word == "--every")
      call.every = std::max(1, std::atoi(argv[i + 1]));
    else if (word == "--size")
      std::sscanf(argv[i + 1], "%dx%d", &call.width, &call.height);
  }
  drive(call);
  return 0;
}

}  // namespace
}  // namespace pavo::bench

int main(int argc, char** argv) {
  return pavo::bench::run(argc, argv);
}
