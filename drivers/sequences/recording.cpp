#include "drivers/sequences/recording.h"

#include <charconv>
#include <cmath>

#include "drivers/calibration/text.h"
#include "drivers/sequences/directory.h"
#include "drivers/sequences/image_size.h"

namespace pavo {
namespace {

namespace fs = std::filesystem;

/// 7 of "000007.png".
std::optional<std::size_t> number_of(const std::string& name) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (error != std::errc{} || *end != '.') return std::nullopt;
  return number;
}

struct SizedImage {
  ImageSize size;
  std::string path;
};

/// Of the first image that can be read: one that cannot is that frame's fault, not the sequence's.
SizedImage first_image_size(const Recording& recording) {
  std::vector<std::uint8_t> bytes;
  std::string first_fault;
  for (const FrameFile& frame : recording.frames) {
    try {
      read_image_file(frame.path, bytes);
      if (const auto size = image_size(bytes)) return {*size, frame.path};
      if (first_fault.empty()) first_fault = frame.path + ": is no image that can be read";
    } catch (const FrameError& error) {
      if (first_fault.empty()) first_fault = error.what();
    }
  }
  throw std::runtime_error(first_fault + " (nor is any other frame of " + recording.info.path + "): expected images");
}

/// The one candidate that there is; "" for none.
std::string own_calibration(const std::vector<fs::path>& candidates) {
  std::string found;
  for (const fs::path& candidate : candidates) {
    if (!is_file(candidate)) continue;
    if (!found.empty()) {
      throw std::runtime_error(found + ": there is " + candidate.filename().string() +
                               " too, and only one can be right: name it with --calibration FILE");
    }
    found = candidate.string();
  }
  return found;
}

/// "a.yaml, b.yaml in FOLDER": the candidates share their folder.
std::string names_of(const std::vector<fs::path>& candidates) {
  std::string names;
  for (const fs::path& candidate : candidates) names += (names.empty() ? "" : ", ") + candidate.filename().string();
  return candidates.empty() ? names : names + " in " + candidates.front().parent_path().string();
}

}  // namespace

Recording record_images(const std::string& layout, const std::string& source, const fs::path& folder) {
  Recording recording;
  recording.info.layout = layout;
  recording.info.path = source;
  for (const std::string& name : list_images(folder)) recording.frames.push_back({(folder / name).string(), name, 0});
  if (recording.frames.empty())
    fail_at(folder.string(), 0, "has no images: expected .png, .jpg, .pgm or the like in it");
  return recording;
}

std::vector<std::size_t> lines_of_frames(const std::vector<FrameFile>& frames, std::size_t lines,
                                         const std::string& file) {
  std::vector<std::size_t> line_of_frame;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto number = lines > frames.size() ? number_of(frames[i].name) : i;
    if (!number || (lines > frames.size() && *number >= lines)) {
      fail_at(file, 0,
              "has " + std::to_string(lines) + " lines for " + std::to_string(frames.size()) +
                  " images, and which of them is " + frames[i].name +
                  "'s is not clear: expected as many lines as images");
    }
    line_of_frame.push_back(*number);
  }
  return line_of_frame;
}

void take_times(Recording& recording, const std::vector<std::int64_t>& times_ns, const std::string& file) {
  if (times_ns.size() < recording.frames.size()) {
    fail_at(file, 0,
            "has " + std::to_string(times_ns.size()) + " times for " + std::to_string(recording.frames.size()) +
                " images: expected one a line for every image");
  }
  const auto line_of_frame = lines_of_frames(recording.frames, times_ns.size(), file);
  for (std::size_t i = 0; i < recording.frames.size(); ++i) recording.frames[i].t_ns = times_ns[line_of_frame[i]];
  recording.info.has_times = true;
}

void take_rate(Recording& recording, double rate_hz) {
  if (recording.info.has_times) return;
  for (std::size_t i = 0; i < recording.frames.size(); ++i) {
    recording.frames[i].t_ns =
        rate_hz > 0 ? std::llround(static_cast<double>(i) * 1e9 / rate_hz) : static_cast<std::int64_t>(i);
  }
  recording.info.has_times = rate_hz > 0;
}

std::optional<Calibration> take_calibration(Recording& recording, const SequenceOptions& options,
                                            const std::vector<fs::path>& candidates, std::optional<int> kitti_camera) {
  const std::string file = options.calibration.empty() ? own_calibration(candidates) : options.calibration;
  if (file.empty()) {
    recording.info.calibration_source = "none: no " + names_of(candidates) + ": give one with --calibration FILE";
    return std::nullopt;
  }
  const SizedImage image = first_image_size(recording);
  Calibration calibration = read_calibration(file, {kitti_camera, image.size.width, image.size.height});
  match_image_size(calibration, image.size.width, image.size.height, image.path);
  recording.info.camera = calibration.camera;
  recording.info.calibration_source = calibration.source;
  return calibration;
}

}  // namespace pavo
