#include <cmath>
#include <functional>

#include "drivers/calibration/text.h"
#include "drivers/sequences/directory.h"
#include "drivers/sequences/layouts.h"
#include "drivers/sequences/sequence.h"

namespace pavo {
namespace {

namespace fs = std::filesystem;

/// A layout that was recognised, and how to open it.
struct Found {
  std::string layout;
  std::function<std::unique_ptr<Sequence>(const SequenceOptions&)> open;
};

template <typename Open>
Found found(const char* layout, Open open) {
  return {layout, [open](const SequenceOptions& options) -> std::unique_ptr<Sequence> {
            return std::make_unique<ImageSequence>(open(options));
          }};
}

std::optional<Found> kitti_raw(const std::string& source, const fs::path& folder, int first, int last) {
  for (int n = first; n <= last; ++n) {
    if (!is_folder(folder / numbered("image_0", n) / "data")) continue;
    return found("KITTI raw", [=](const auto& options) { return open_kitti_raw(source, folder, n, options); });
  }
  return std::nullopt;
}

std::optional<Found> kitti_odometry(const std::string& source, const fs::path& folder, int first, int last) {
  for (int n = first; n <= last; ++n) {
    if (!is_folder(folder / numbered("image_", n))) continue;
    return found("KITTI odometry",
                 [=](const auto& options) { return open_kitti_odometry(source, folder, n, options); });
  }
  return std::nullopt;
}

/// The camera's folder of an EuRoC sequence that is given by any of its folders.
std::optional<Found> euroc(const std::string& source, const fs::path& folder) {
  for (const fs::path& camera : {folder / "mav0" / "cam0", folder / "cam0", folder}) {
    if (!is_file(camera / "data.csv") || !is_folder(camera / "data")) continue;
    return found("EuRoC", [=](const auto& options) { return open_euroc(source, camera, options); });
  }
  return std::nullopt;
}

/// `folder` is image_2 of a KITTI sequence, or image_02 of a KITTI drive: the way to name another camera than the
/// first.
std::optional<Found> camera_of_kitti(const std::string& source, const fs::path& folder) {
  const fs::path absolute = fs::weakly_canonical(folder);
  const std::string name = absolute.filename().string();
  for (int n = 0; n < 4; ++n) {
    if (name == numbered("image_0", n)) return kitti_raw(source, absolute.parent_path(), n, n);
    const bool beside_calibration =
        is_file(absolute.parent_path() / "calib.txt") || is_file(absolute.parent_path() / "times.txt");
    if (name == numbered("image_", n) && beside_calibration)
      return kitti_odometry(source, absolute.parent_path(), n, n);
  }
  return std::nullopt;
}

std::optional<Found> images(const std::string& source, const fs::path& folder) {
  for (const fs::path& place : {folder / "images", folder}) {
    if (!is_folder(place) || list_images(place).empty()) continue;
    return found("images", [=](const auto& options) { return open_image_folder(source, folder, place, options); });
  }
  return std::nullopt;
}

Found recognise_folder(const std::string& source, const fs::path& folder) {
  if (is_empty_folder(folder))
    fail_at(source, 0, "is empty: expected a recorded sequence (KITTI, EuRoC, TUM RGB-D, or images)");
  if (auto layout = euroc(source, folder)) return *layout;
  if (auto layout = kitti_raw(source, folder, 0, 3)) return *layout;
  if (auto layout = kitti_odometry(source, folder, 0, 3)) return *layout;
  if (is_file(folder / "rgb.txt")) {
    return found("TUM RGB-D", [=](const auto& options) { return open_tum_rgbd(source, folder, options); });
  }
  if (auto layout = camera_of_kitti(source, folder)) return *layout;
  if (auto layout = images(source, folder)) return *layout;
  fail_at(source, 0,
          "no recorded sequence recognised: looked for image_0/ ... image_3/ (KITTI odometry), image_00/data/ ... "
          "image_03/data/ "
          "(KITTI raw), mav0/cam0/data.csv with data/ (EuRoC), rgb.txt (TUM RGB-D), images/*.png or *.png, *.jpg, "
          "*.pgm (images): "
          "give a directory that has one of them");
}

Found recognise(const std::string& source) {
  std::error_code error;
  const fs::file_status status = fs::status(source, error);
  if (status.type() == fs::file_type::not_found) {
    fail_at(source, 0, "does not exist: expected a directory with a recorded sequence, or a video file");
  }
  if (error) fail_at(source, 0, "cannot be looked at (" + error.message() + ")");
  if (fs::is_directory(status)) return recognise_folder(source, source);
  if (!fs::is_regular_file(status)) {
    fail_at(source, 0, "is neither a directory nor a regular file: expected a recorded sequence or a video file");
  }
  if (is_image_name(fs::path(source).filename().string())) {
    fail_at(source, 0, "is a single image: expected its folder, or a video file");
  }
  return {"video", [source](const SequenceOptions& options) { return open_video(source, options); }};
}

/// std::filesystem says what cannot be read in its own way; our messages are one line of our own.
template <typename Work>
auto with_readable_errors(Work work) {
  try {
    return work();
  } catch (const fs::filesystem_error& error) {
    fail_at(error.path1().string(), 0,
            "cannot be read (" + error.code().message() + "): give a folder that can be read");
  }
}

}  // namespace

std::string recognise_layout(const std::string& source) {
  return with_readable_errors([&] { return recognise(source).layout; });
}

std::unique_ptr<Sequence> open_sequence(const std::string& source, const SequenceOptions& options) {
  if (!std::isfinite(options.rate_hz) || options.rate_hz < 0 || options.rate_hz > 1e6) {
    throw std::runtime_error("--rate " + std::to_string(options.rate_hz) +
                             ": expected frames a second, from 0 (none) to 1e6");
  }
  return with_readable_errors([&] { return recognise(source).open(options); });
}

}  // namespace pavo
