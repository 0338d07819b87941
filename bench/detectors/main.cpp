// FAST + SURF beside the detectors and descriptors that Debian's OpenCV ships: how many points, how many of their
// matches are right, what motion do they give, and what does it cost?
//
//   bench_detectors [--every N] [--pictures DIR] [--simd TARGET]
//
// Prints the tables of docs/features.md. --every: the N-th frames are taken, each with the one before it (default 6).
// --pictures: draws the matches of one pair of the synthetic street into DIR, by every competitor, and matches.jpg with
// all of them. --simd: what pavo's own code runs on (SSE4, AVX2, ...; the default is the best). PAVO_DATA names the
// folder with the recorded sequences; without it, only the synthetic street is taken.
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>

#include "bench/detectors/judge.h"
#include "bench/detectors/measure.h"
#include "bench/detectors/pictures.h"
#include "pavo/simd.h"

namespace pavo::bench {
namespace {

struct Arguments {
  int every = 6;
  std::string pictures;
};

Arguments parse(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; i += 2) {
    const std::string option = argv[i], value = i + 1 < argc ? argv[i + 1] : "";
    if (option == "--every")
      arguments.every = std::atoi(value.c_str());
    else if (option == "--pictures" && !value.empty())
      arguments.pictures = value;
    else if (option == "--simd" && !value.empty())
      force_simd(value);
    else
      throw std::runtime_error(option + ": expected --every N, --pictures DIR or --simd TARGET");
  }
  if (arguments.every < 2) throw std::runtime_error("--every: expected a number, at least 2");
  return arguments;
}

Competitors all_competitors() {
  Competitors all;
  add_fast_surf(all);
  add_corners_surf(all);
  add_klt(all);
  add_orb(all);
  add_brisk(all);
  add_sift(all);
  add_kaze(all);
  add_akaze(all);
  return all;
}

std::string file_name(const std::string& title) {
  std::string name;
  for (const char c : title) {
    if (std::isalnum(static_cast<unsigned char>(c)))
      name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (!name.empty() && name.back() != '-')
      name += '-';
  }
  while (!name.empty() && name.back() == '-') name.pop_back();
  return name;
}

void write_pictures(Competitors& competitors, const DataSet& street, const std::string& folder) {
  std::filesystem::create_directories(folder);
  const FramePair& pair = street.pairs[street.pairs.size() / 2];
  std::vector<Tile> tiles;
  for (auto& competitor : competitors) {
    const PointPairs pairs = check(*competitor, street, pair);
    const std::vector<std::uint8_t> right = right_ones(pairs, street.camera, pair.T_c_p);
    const auto n = static_cast<std::size_t>(std::count(right.begin(), right.end(), 1));
    tiles.push_back(
        {competitor->name() + ": " + std::to_string(n) + " right, " + std::to_string(pairs.size() - n) + " wrong",
         draw_matches(pair.current, pairs, right)});
    write_picture(folder + "/" + file_name(competitor->name()) + ".png", tiles.back().picture);
  }
  write_picture(folder + "/matches.jpg", contact_sheet(tiles));
}

int run(const Arguments& arguments) {
  cv::setNumThreads(1);
  Competitors competitors = all_competitors();
  const std::vector<DataSet> sets = load_data_sets(arguments.every);
  for (const DataSet& set : sets)
    for (auto& competitor : competitors) check(*competitor, set, set.pairs.at(0));
  if (!arguments.pictures.empty()) write_pictures(competitors, sets.front(), arguments.pictures);

  std::vector<Times> times(competitors.size());
  std::vector<std::vector<Figures>> figures(sets.size(), std::vector<Figures>(competitors.size()));
  for (std::size_t s = 0; s < sets.size(); ++s)
    for (const FramePair& pair : sets[s].pairs)
      for (std::size_t i = 0; i < competitors.size(); ++i)
        measure(*competitors[i], sets[s], pair, times[i], figures[s][i]);

  std::vector<double> fast_ms;
  for (const Times& t : times) fast_ms.insert(fast_ms.end(), t.fast_ms.begin(), t.fast_ms.end());
  std::printf("OpenCV %s, pavo on %s, one thread, F = %.2f ms (medians over all pairs of frames)\n\n", CV_VERSION,
              simd_target().c_str(), median(fast_ms));
  print_times(competitors, times);
  for (std::size_t s = 0; s < sets.size(); ++s) print_figures(competitors, sets[s], figures[s]);
  return 0;
}

}  // namespace
}  // namespace pavo::bench

int main(int argc, char** argv) {
  try {
    return pavo::bench::run(pavo::bench::parse(argc, argv));
  } catch (const std::exception& error) {
    std::cerr << "bench_detectors: " << error.what() << "\n";
    return 1;
  }
}
