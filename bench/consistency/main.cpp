// Does the covariance say how far off the poses are? Many short drives through the synthetic street, each with another
// seed; the normalised estimation error squared (NEES; Bar-Shalom, Li and Kirubarajan, 2001, 5.4) of every frame,
// averaged over the drives, against the band in which 95 % of such averages lie.
//
//   bench_consistency [--runs 50] [--first-seed 1] [--frames 100] [--size 640x192] [--people] [--truth-lengths]
//                     [--every N] [--dump FILE] [FOLDER...]
//
// A folder (KITTI's layout, with ground truth) is a run of its own, instead of the synthetic ones.
#include <Eigen/Cholesky>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <opencv2/core/utility.hpp>
#include <string>
#include <vector>

#include "drivers/sequences/sequence.h"
#include "drivers/synthetic/synthetic_street.h"
#include "pavo/keyframe_stages.h"
#include "pavo/plain_loop.h"
#include "stages/decode/decode.h"
#include "stages/map/se3_step.h"

namespace pavo::bench {
namespace {

struct Call {
  int runs = 50, frames = 100, width = 640, height = 192, every = 10, first_seed = 1;
  bool people = false, truth_lengths = false;
  std::string dump;
  std::vector<std::string> folders;
};

/// What one frame of one run says: its error in the camera's frame, and the covariance that was told.
struct Sample {
  Vector6d error;
  Matrix6d covariance;
  double nees() const { return error.dot(covariance.ldlt().solve(error)); }
};
using Run = std::vector<Sample>;

Run drive(Sequence& sequence, const Call& call) {
  const SequenceInfo& info = sequence.info();
  PlainLoopOptions options;
  std::shared_ptr<const StepLength> lengths = std::make_shared<UnknownStep>();
  if (call.truth_lengths) {
    lengths = std::make_shared<GroundtruthStep>(*info.groundtruth);
  } else {
    options.map.ground.emplace();
    options.map.ground->filter.height_m = 1.65;
    options.odometry.systematic.log_scale = kToldHeightLogSigma;
  }
  PlainLoop loop(*info.camera, options, lengths);
  const Decode decode(info.camera->width, info.camera->height);
  Decode::Scratch scratch;
  EncodedImage encoded;
  FrameStamp stamp;
  Image image;
  Run run;
  const People nobody;
  while (static_cast<int>(run.size()) < call.frames && sequence.read(encoded, stamp)) {
    decode(encoded, image, scratch);
    const PoseResult& pose = loop({.index = stamp.index, .t_ns = stamp.t_capture_ns}, image, nobody);
    run.push_back({step_between(pose.T_w_c, info.groundtruth->T_w_c[run.size()]), pose.covariance});
  }
  return run;
}

std::vector<Run> drive_all(const Call& call) {
  std::vector<Run> runs;
  for (const std::string& folder : call.folders) runs.push_back(drive(*open_sequence(folder), call));
  for (int seed = call.first_seed; call.folders.empty() && seed < call.first_seed + call.runs; ++seed) {
    SyntheticOptions street;
    street.seed = static_cast<std::uint64_t>(seed);
    street.frames = call.frames;
    street.width = call.width, street.height = call.height;
    street.people = call.people;
    SyntheticStreet sequence(street);
    runs.push_back(drive(sequence, call));
    std::fprintf(stderr, "seed %d: NEES at the end %.1f\n", seed, runs.back().back().nees());
  }
  return runs;
}

/// Of a chi-square variable (Wilson and Hilferty, 1931): z = -1.96 and 1.96 are the 2.5 and 97.5 % quantiles.
double chi_square_quantile(double freedom, double z) {
  const double root = 1 - 2 / (9 * freedom) + z * std::sqrt(2 / (9 * freedom));
  return freedom * root * root * root;
}

void write(const std::string& file, const std::vector<Run>& runs) {
  std::ofstream out(file);
  for (std::size_t r = 0; r < runs.size(); ++r) {
    for (std::size_t k = 0; k < runs[r].size(); ++k) {
      out << r << ' ' << k;
      for (const double x : runs[r][k].error) out << ' ' << x;
      for (const double x : runs[r][k].covariance.reshaped()) out << ' ' << x;
      out << '\n';
    }
  }
}

void print(const std::vector<Run>& runs, const Call& call) {
  const double n = static_cast<double>(runs.size());
  const double low = chi_square_quantile(6 * n, -1.96) / n, high = chi_square_quantile(6 * n, 1.96) / n;
  std::printf("%zu runs; mean NEES in [%.2f, %.2f] is consistent (95 %%, 6 numbers)\n\n", runs.size(), low, high);
  std::printf("| frame | NEES | median | error / told: x | y | z | rx | ry | rz |\n");
  std::printf("| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  std::size_t shortest = runs[0].size();
  for (const Run& run : runs) shortest = std::min(shortest, run.size());
  int inside = 0, all = 0;
  double total = 0;
  for (std::size_t k = 1; k < shortest; ++k) {
    double sum = 0;
    std::vector<double> each;
    Vector6d square = Vector6d::Zero();
    for (const Run& run : runs) {
      each.push_back(run[k].nees());
      sum += each.back();
      square += run[k].error.cwiseAbs2().cwiseQuotient(run[k].covariance.diagonal());
    }
    std::nth_element(each.begin(), each.begin() + static_cast<std::ptrdiff_t>(each.size() / 2), each.end());
    const double mean = sum / n;
    ++all, inside += mean >= low && mean <= high, total += mean;
    if (static_cast<int>(k) % call.every != 0 && k + 1 != shortest) continue;
    std::printf("| %zu | %.2f | %.2f |", k, mean, each[each.size() / 2]);
    for (const double x : square) std::printf(" %.2f |", std::sqrt(x / n));
    std::printf("\n");
  }
  std::printf("\nframes inside the band: %d of %d; mean over all frames %.2f\n", inside, all, total / all);
}

int run(int argc, char** argv) {
  cv::setNumThreads(1);
  Call call;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto value = [&] { return i + 1 < argc ? std::string(argv[++i]) : std::string(); };
    if (word == "--runs")
      call.runs = std::atoi(value().c_str());
    else if (word == "--frames")
      call.frames = std::atoi(value().c_str());
    else if (word == "--every")
      call.every = std::max(1, std::atoi(value().c_str()));
    else if (word == "--first-seed")
      call.first_seed = std::atoi(value().c_str());
    else if (word == "--size")
      std::sscanf(value().c_str(), "%dx%d", &call.width, &call.height);
    else if (word == "--people")
      call.people = true;
    else if (word == "--truth-lengths")
      call.truth_lengths = true;
    else if (word == "--dump")
      call.dump = value();
    else
      call.folders.push_back(word);
  }
  const std::vector<Run> runs = drive_all(call);
  if (runs.empty()) return 1;
  if (!call.dump.empty()) write(call.dump, runs);
  print(runs, call);
  return 0;
}

}  // namespace
}  // namespace pavo::bench

int main(int argc, char** argv) {
  return pavo::bench::run(argc, argv);
}
