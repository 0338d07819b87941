#include "tools/pavo/undistort.h"

#include <fmt/format.h>

#include <atomic>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>

#include "drivers/calibration/calibration.h"
#include "drivers/calibration/write_calibration.h"
#include "drivers/recording/encode_png.h"
#include "drivers/trajectories/append_file.h"
#include "stages/undistort/undistort.h"
#include "tools/pavo/picture_files.h"
#include "tools/pavo/progress.h"
#include "tools/pavo/usage_error.h"

namespace pavo {
namespace {

namespace fs = std::filesystem;

struct UndistortCall {
  std::vector<std::string> pictures;
  std::string calibration, out;
  double alpha = 0;
  bool compare = false;
};

// Two of the same name would overwrite each other, and one in its own folder its source.
std::map<fs::path, fs::path> targets_of(const std::vector<fs::path>& files, const fs::path& folder) {
  std::map<fs::path, fs::path> targets, sources;
  for (const fs::path& file : files) {
    const fs::path target = folder / (file.stem().string() + ".png");
    std::error_code not_there;
    if (fs::equivalent(target, file, not_there))
      throw UsageError("--out " + folder.string() + ": " + file.string() + " would be overwritten");
    if (const auto [at, fresh] = sources.emplace(target, file); !fresh && at->second != file)
      throw std::runtime_error(file.string() + " and " + at->second.string() + " would both become " + target.string() +
                               ": undistort them into folders of their own");
    targets[file] = target;
  }
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder))
    throw std::runtime_error("--out " + folder.string() +
                             ": this folder cannot be made: " + (error ? error.message() : "it is no directory"));
  return targets;
}

// Before on the left, after on the right, with lines through both that are straight: what the lens bent is seen
// against them.
void draw_both(const Image& before, const Image& after, Image& both) {
  constexpr int kGap = 8, kLines = 6;
  constexpr std::uint8_t kPaper = 255;
  const int width = before.width(), height = before.height();
  both.resize(2 * width + kGap, height);
  for (int y = 0; y < height; ++y) {
    std::memset(both.row(y), kPaper, static_cast<std::size_t>(both.width()));
    std::memcpy(both.row(y), before.row(y), static_cast<std::size_t>(width));
    std::memcpy(both.row(y) + width + kGap, after.row(y), static_cast<std::size_t>(width));
  }
  for (int i = 1; i < kLines; ++i)
    for (int x = 0; x < both.width(); ++x) both.at(x, i * height / kLines) = x % 8 < 4 ? 255 : 0;
}

void write_png(EncodePng& encode, const Image& image, const fs::path& to) {
  std::vector<std::uint8_t> png;
  encode(image.view(), png);
  write_whole_file(to, std::string_view(reinterpret_cast<const char*>(png.data()), png.size()));
}

int undistort(const UndistortCall& call) {
  if (call.out.empty()) throw UsageError("--out is empty: expected the folder to write to");
  const std::vector<fs::path> files = picture_files(call.pictures);
  Calibration calibration = read_calibration(call.calibration);
  const std::map<fs::path, fs::path> targets = targets_of(files, call.out);
  PictureReader read;
  EncodePng encode;
  std::unique_ptr<Undistort> straighten;
  Image before, after, both;
  std::atomic<std::int64_t> done{0};
  {
    const Progress progress("undistort", static_cast<std::int64_t>(files.size()), [&] { return done.load(); });
    for (const fs::path& file : files) {
      read(file, before);
      match_image_size(calibration, before.width(), before.height(), file.string());
      if (!straighten) straighten = std::make_unique<Undistort>(calibration.camera, call.alpha);
      (*straighten)(before, after);
      const fs::path& target = targets.at(file);
      write_png(encode, after, target);
      if (call.compare) {
        draw_both(before, after, both);
        write_png(encode, both, target.parent_path() / (target.stem().string() + ".compare.png"));
      }
      ++done;
    }
  }
  write_whole_file(fs::path(call.out) / "camera.yaml", ros_camera_info(straighten->rectified_camera(), "undistorted"));
  fmt::print("{}: {} pictures without distortion, and camera.yaml, which is their camera\n", call.out, files.size());
  return 0;
}

}  // namespace

void register_undistort(CLI::App& app, int& status) {
  auto call = std::make_shared<UndistortCall>();
  CLI::App& command = *app.add_subcommand("undistort", "Take the lens's distortion out of pictures");
  command.footer("Example: pavo undistort boards/ --calibration camera.yaml --out straight/ --compare");
  command.add_option("pictures", call->pictures, "image files, or folders of them")
      ->type_name("IMAGE|DIR...")
      ->required();
  command.add_option("--calibration", call->calibration, "the camera, as `pavo calibrate` writes it")
      ->type_name("FILE")
      ->required();
  command.add_option("--out", call->out, "folder for the pictures (gray, PNG) and their new camera.yaml")
      ->type_name("DIR")
      ->required();
  command.add_option("--alpha", call->alpha, "0 keeps K (default), 1 widens the view to all pixels")
      ->type_name("0..1")
      ->check(CLI::Range(0., 1.).description(""));
  command.add_flag("--compare", call->compare, "NAME.compare.png beside each: before and after, with straight lines");
  command.callback([call, &status] { status = undistort(*call); });
}

}  // namespace pavo
