#include "tools/pavo/detect.h"

#include <fmt/format.h>

#include <oneapi/tbb/task_arena.h>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <thread>

#include "drivers/models/model_file.h"
#include "stages/people/arena_spread.h"
#include "stages/people/scan_hog.h"
#include "tools/pavo/csv_field.h"
#include "tools/pavo/picture_files.h"
#include "tools/pavo/progress.h"
#include "tools/pavo/usage_error.h"

namespace pavo {
namespace {

namespace fs = std::filesystem;

struct DetectCall {
  std::vector<std::string> pictures;
  std::string model;
  std::string draw;
  bool json = false;
  double threshold = -1;
  int border = ScanHogOptions{}.border_cells;
  int workers = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
};

void print_csv(const fs::path& file, const Detections& people) {
  for (const PersonBox& p : people)
    fmt::print("{},{:.1f},{:.1f},{:.1f},{:.1f},{:.6f}\n", csv_field(file.filename().string()), p.x, p.y, p.width,
               p.height, p.score);
}

nlohmann::json as_json(const fs::path& file, const Image& image, const Detections& people) {
  nlohmann::json boxes = nlohmann::json::array();
  for (const PersonBox& p : people)
    boxes.push_back({{"x", p.x}, {"y", p.y}, {"width", p.width}, {"height", p.height}, {"score", p.score}});
  return {{"image", file.filename().string()}, {"width", image.width()}, {"height", image.height()}, {"people", boxes}};
}

/// A box and its score in %, the surer the more opaque.
void draw(const fs::path& to, const Image& image, const Detections& people) {
  cv::Mat gray(image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.row(0)),
               static_cast<std::size_t>(image.stride()));
  cv::Mat picture;
  cv::cvtColor(gray, picture, cv::COLOR_GRAY2BGR);
  for (const PersonBox& p : people) {
    const cv::Scalar yellow(0, 140 + 115 * static_cast<double>(p.score), 255 * static_cast<double>(p.score));
    cv::rectangle(picture, cv::Rect2f(p.x, p.y, p.width, p.height), yellow, 2, cv::LINE_AA);
    cv::putText(picture, fmt::format("{:.0f}", 100 * p.score), cv::Point2f(p.x, p.y - 4), cv::FONT_HERSHEY_SIMPLEX, 0.5,
                yellow, 1, cv::LINE_AA);
  }
  if (!cv::imwrite(to.string(), picture)) throw std::runtime_error(to.string() + ": cannot be written");
}

/// Where the drawing of each picture goes: its name as PNG. Two of the same name would overwrite each other, and one in
/// its own folder its source.
std::map<fs::path, fs::path> drawings(const std::vector<fs::path>& files, const fs::path& folder) {
  std::map<fs::path, fs::path> targets, sources;
  for (const fs::path& file : files) {
    const fs::path target = folder / (file.stem().string() + ".png");
    std::error_code not_there;
    if (fs::equivalent(target, file, not_there))
      throw UsageError("--draw " + folder.string() + ": " + file.string() + " would be overwritten");
    if (const auto [at, fresh] = sources.emplace(target, file); !fresh && at->second != file)
      throw std::runtime_error(file.string() + " and " + at->second.string() + " would both be drawn as " +
                               target.string() + ": draw them into folders of their own");
    targets[file] = target;
  }
  fs::create_directories(folder);
  return targets;
}

int detect(const DetectCall& call) {
  const PedestrianModel model = call.model.empty() ? default_pedestrian_model() : read_pedestrian_model(call.model);
  const std::vector<fs::path> files = picture_files(call.pictures);
  std::map<fs::path, fs::path> targets;
  if (!call.draw.empty()) targets = drawings(files, call.draw);

  tbb::task_arena arena(call.workers);
  ArenaSpread helpers(arena);
  const ScanPeopleHog scan(
      model, {.border_cells = call.border, .threshold = static_cast<float>(call.threshold), .spread = &helpers});
  ScanPeopleHog::Scratch scratch;
  PictureReader read;
  Image image;
  Detections people;
  nlohmann::json all = nlohmann::json::array();
  std::vector<std::string> failures, small;
  if (!call.json) fmt::print("image,x,y,width,height,score\n");
  {
    std::atomic<std::int64_t> done{0};
    const Progress progress("detect", static_cast<std::int64_t>(files.size()), [&] { return done.load(); });
    for (const fs::path& file : files) {
      ++done;
      try {
        read(file, image);
      } catch (const std::runtime_error& e) {
        failures.emplace_back(e.what());
        continue;
      }
      if (image.width() < hog::kWindowWidth || image.height() < hog::kWindowHeight)
        small.push_back(fmt::format("{}: {}x{} pixels, smaller than a window of {}x{}: nobody can be found in it",
                                    file.string(), image.width(), image.height(), hog::kWindowWidth,
                                    hog::kWindowHeight));
      scan(image, people, scratch);
      if (call.json)
        all.push_back(as_json(file, image, people));
      else
        print_csv(file, people);
      if (targets.empty()) continue;
      try {
        draw(targets.at(file), image, people);
      } catch (const std::exception& e) {  // what was found is worth more than its picture
        failures.emplace_back(e.what());
      }
    }
  }
  if (call.json) fmt::print("{}\n", all.dump(1));
  for (const std::string& note : small) fmt::print(stderr, "pavo: {}\n", note);
  for (const std::string& error : failures) fmt::print(stderr, "pavo: {}\n", error);
  return failures.empty() ? 0 : 1;
}

}  // namespace

void register_detect(CLI::App& app, int& status) {
  auto call = std::make_shared<DetectCall>();
  CLI::App& command = *app.add_subcommand("detect", "Find people in pictures");
  command.footer(
      "Example: pavo detect photos/ --draw found/ > people.csv\n"
      "Boxes are of the persons, in pixels; scores are probabilities. People lower than about 100 px are not found.");
  command.add_option("pictures", call->pictures, "image files, or folders of them")
      ->type_name("IMAGE|DIR...")
      ->required();
  command.add_option("--model", call->model, "a classifier from `pavo train` (default: the one built in)")
      ->type_name("FILE");
  command.add_option("--threshold", call->threshold, "smallest score (default: the model's own)")
      ->type_name("P")
      ->check(CLI::Range(0.0, 1.0).description(""));
  command
      .add_option("--border", call->border,
                  fmt::format("cells of 8 px that a window may reach beyond the image (default {})", call->border))
      ->type_name("CELLS")
      ->check(CLI::Range(0, 16).description(""));
  command.add_flag("--json", call->json, "JSON in place of CSV");
  command.add_option("--draw", call->draw, "write the pictures with the boxes, as PNG, into this folder")
      ->type_name("DIR");
  command.add_option("--workers", call->workers, "threads (default: one per core)")
      ->type_name("N")
      ->check(CLI::Range(1, 256).description(""));
  command.callback([call, &status] { status = detect(*call); });
}

}  // namespace pavo
