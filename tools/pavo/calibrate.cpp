#include "tools/pavo/calibrate.h"

#include <fmt/format.h>

#include <atomic>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>

#include "drivers/sequences/directory.h"
#include "drivers/sequences/sequence.h"
#include "drivers/trajectories/append_file.h"
#include "tools/pavo/calibration_report.h"
#include "tools/pavo/picture_files.h"
#include "tools/pavo/progress.h"
#include "tools/pavo/signals.h"
#include "tools/pavo/usage_error.h"
#include "tools/pavo/watch_board.h"

namespace pavo {
namespace {

namespace fs = std::filesystem;

struct CalibrateCall {
  std::vector<std::string> sources;
  std::string board_text, lens = "pinhole", out, name = "camera";
  Board board;
  FeedOptions camera{.newest = true};
  int views = 25;
};

// Views of the board, all of one size.
struct Found {
  int width = 0, height = 0;
  std::vector<BoardCorners> views;
  std::vector<std::string> names;
  std::vector<std::string> without;  ///< pictures in which there is no board
};

Board board_named(const std::string& text, double square_m) {
  Board board{.square_m = square_m};
  int end = 0;
  const bool read = std::sscanf(text.c_str(), "%dx%d%n", &board.columns, &board.rows, &end) == 2;
  if (!read || end != static_cast<int>(text.size()) || board.columns < 3 || board.rows < 3 || board.columns > 100 ||
      board.rows > 100)
    throw UsageError(
        "--board must be COLUMNSxROWS of inner corners, 3 to 100 each, such as 9x6 for a board of 10x7 squares, not '" +
        text + "'");
  return board;
}

Found find_in_pictures(const std::vector<std::string>& paths, const Board& board) {
  const std::vector<fs::path> files = picture_files(paths);
  Found found;
  PictureReader read;
  Image image;
  std::atomic<std::int64_t> done{0};
  const Progress progress("calibrate", static_cast<std::int64_t>(files.size()), [&] { return done.load(); });
  for (const fs::path& file : files) {
    read(file, image);
    if (found.width == 0) {
      found.width = image.width();
      found.height = image.height();
    }
    if (image.width() != found.width || image.height() != found.height)
      throw std::runtime_error(fmt::format("{}: has {}x{}, but {} has {}x{}: a calibration needs pictures of one size",
                                           file.string(), image.width(), image.height(), files.front().string(),
                                           found.width, found.height));
    BoardCorners corners = find_board(image.view(), board);
    if (corners.empty()) {
      found.without.push_back(file.string());
    } else {
      found.views.push_back(std::move(corners));
      found.names.push_back(file.filename().string());
    }
    ++done;
  }
  return found;
}

// Is it something that is watched, and not a list of pictures? A camera, a video, a recorded sequence with times.
bool is_watched(const std::vector<std::string>& sources) {
  if (sources.size() != 1) return false;
  const fs::path source = sources.front();
  if (is_camera(source)) return true;
  if (fs::is_regular_file(source)) return !is_image_name(source.filename().string());
  return fs::is_directory(source) && list_images(source).empty();
}

Found find_by_watching(const CalibrateCall& call) {
  Found found;
  WatchedBoard watched = watch_board(call.sources.front(), call.camera, call.board, call.views);
  found.width = watched.width;
  found.height = watched.height;
  found.views = std::move(watched.views);
  for (std::size_t v = 0; v < found.views.size(); ++v) found.names.push_back(fmt::format("view {}", v + 1));
  return found;
}

void check_board_was_there(const Found& found, const CalibrateCall& call) {
  if (!found.views.empty()) return;
  throw std::runtime_error(fmt::format(
      "{}: no board of {}x{} inner corners was found in it: is --board right (it counts corners between squares, not "
      "squares), all of the board in the picture, its white margin free?",
      call.sources.front() + (call.sources.size() > 1 ? fmt::format(" and {} more", call.sources.size() - 1) : ""),
      call.board.columns, call.board.rows));
}

void check_places(const CalibrateCall& call) {
  for (const std::string& source : call.sources)
    if (source.empty()) throw UsageError("a source is empty: expected pictures, folders, a video or a camera");
  if (call.out.empty()) throw UsageError("--out is empty: expected the calibration file to write");
  const std::string extension = fs::path(call.out).extension();
  if (extension != ".yaml" && extension != ".yml")
    throw UsageError("--out " + call.out + ": expected a name that ends in .yaml");
  for (const char c : call.name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_')
      throw UsageError("--name must be letters, digits and '_', not '" + call.name + "'");
}

int calibrate(CalibrateCall call) {
  check_places(call);
  call.board = board_named(call.board_text, call.board.square_m);
  const Found found = is_watched(call.sources) ? find_by_watching(call) : find_in_pictures(call.sources, call.board);
  check_board_was_there(found, call);
  const Lens lens = call.lens == "equidistant" ? Lens::equidistant : Lens::radial_tangential;
  const CalibrationResult result = calibrate_camera(found.views, call.board, found.width, found.height, lens);
  const CalibrationReport report{result, call.board, found.views, found.names};

  const fs::path out(call.out);
  write_whole_file(out, calibration_yaml(report, call.name));
  const std::string picture = fs::path(out).replace_extension(".svg"), json = fs::path(out).replace_extension(".json");
  write_whole_file(picture, calibration_picture(report));
  write_whole_file(json, calibration_json(report).dump(1) + "\n");
  fmt::print("{}", calibration_table(report));
  for (const std::string& without : found.without) fmt::print("  no board  {}\n", without);
  fmt::print("  written: {}, {}, {}\n", call.out, picture, json);
  for (const std::string& warning : calibration_warnings(report)) fmt::print(stderr, "pavo: warning: {}\n", warning);
  return 0;
}

}  // namespace

void register_calibrate(CLI::App& app, int& status) {
  auto call = std::make_shared<CalibrateCall>();
  CLI::App& command = *app.add_subcommand("calibrate", "Find a camera's parameters from views of a chessboard");
  command.footer(
      "Example: pavo calibrate /dev/video0 --board 9x6 --out camera.yaml\n"
      "From a camera, a view is taken whenever the board holds still in a new place; Ctrl-C calibrates with what is "
      "there.\nBeside FILE.yaml: FILE.svg (where the board was seen, and the errors) and FILE.json. docs/cameras.md "
      "has "
      "more.");
  command
      .add_option("SOURCE", call->sources,
                  "pictures, folders of them; or one camera (/dev/videoN), video or recorded sequence")
      ->type_name("IMAGE|DIR|VIDEO|DEVICE...")
      ->required();
  command.add_option("--board", call->board_text, "inner corners: 9x6 for a board of 10x7 squares")
      ->type_name("COLUMNSxROWS")
      ->required();
  command
      .add_option("--square", call->board.square_m,
                  "a square's side (default 0.04); the calibration is the same for any")
      ->type_name("METRES")
      ->check(CLI::Range(1e-4, 100.).description(""));
  command.add_option("--lens", call->lens, "pinhole (default) or equidistant (fisheye)")
      ->type_name("NAME")
      ->check(CLI::IsMember({"pinhole", "equidistant"}));
  command.add_option("--views", call->views, "how many to take from a camera (default 25)")
      ->type_name("N")
      ->check(CLI::Range(kFewestViews, 1000).description(""));
  add_feed_options(command, call->camera);
  command.remove_option(command.get_option("--calibration"));
  command.add_option("--name", call->name, "of the camera, in the file (default camera)")->type_name("NAME");
  command.add_option("--out", call->out, "the calibration, as ROS's camera_info YAML")
      ->type_name("FILE.yaml")
      ->required();
  command.callback([call, &status] { status = calibrate(*call); });
}

}  // namespace pavo
