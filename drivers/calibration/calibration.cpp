#include "drivers/calibration/calibration.h"

#include "drivers/calibration/camera_check.h"
#include "drivers/calibration/kitti_file.h"
#include "drivers/calibration/text.h"
#include "drivers/calibration/yaml_calibration.h"
#include "drivers/trajectories/append_file.h"

namespace pavo {
namespace {

constexpr std::size_t kLargestFile = 1 << 20;

/// "P" and 2: "P2".
std::string numbered(std::string prefix, int n) {
  prefix += static_cast<char>('0' + n);
  return prefix;
}

/// Which of the cameras `prefix`0..3: the caller's, or 0, or the only one that there is.
int choose_camera(const KittiFile& file, const std::string& prefix, const CalibrationHints& hints) {
  if (hints.kitti_camera) return *hints.kitti_camera;
  std::vector<int> found;
  for (int n = 0; n < 4; ++n) {
    if (file.has(numbered(prefix, n))) found.push_back(n);
  }
  if (found.empty() || found.front() == 0) return 0;
  if (found.size() == 1) return found.front();
  fail_at(file.name(), file.line(numbered(prefix, found[1])),
          "has several cameras but no " + prefix + "0: keep only the one that took the images");
}

Calibration from_projection(const KittiFile& file, const std::string& key) {
  Calibration calibration;
  set_intrinsics(calibration.camera, file.numbers(key, 12), 4, {file.name(), file.line(key), key});
  calibration.source = file.name() + ", " + key;
  return calibration;
}

void read_kitti_size(Calibration& calibration, const KittiFile& file, const std::string& key) {
  const auto size = file.numbers(key, 2);
  set_size(calibration.camera, size[0], size[1], {file.name(), file.line(key), key});
}

/// The camera before rectification, which KITTI's "extract" drives hold.
Calibration from_raw_camera(const KittiFile& file, int n) {
  Calibration calibration;
  set_intrinsics(calibration.camera, file.numbers(numbered("K_0", n), 9), 3,
                 {file.name(), file.line(numbered("K_0", n)), numbered("K_0", n)});
  set_distortion(calibration.camera, Lens::radial_tangential, file.numbers(numbered("D_0", n), 5),
                 {file.name(), file.line(numbered("D_0", n)), numbered("D_0", n)});
  read_kitti_size(calibration, file, numbered("S_0", n));
  calibration.source =
      file.name() + ", " + numbered("K_0", n) + " and " + numbered("D_0", n) + " (images before rectification)";
  return calibration;
}

Calibration from_kitti(const KittiFile& file, const CalibrationHints& hints) {
  const bool raw = file.has("P_rect_00") || file.has("P_rect_01") || file.has("P_rect_02") || file.has("P_rect_03") ||
                   file.has("K_00") || file.has("K_01") || file.has("K_02") || file.has("K_03");
  if (!raw) return from_projection(file, numbered("P", choose_camera(file, "P", hints)));

  const int n = choose_camera(file, "P_rect_0", hints);
  if (hints.width > 0 && file.has(numbered("S_0", n)) && file.has(numbered("K_0", n))) {
    const std::vector<double> size = {double(hints.width), double(hints.height)};
    const bool is_unrectified = file.numbers(numbered("S_0", n), 2) == size;
    const bool is_rectified = file.has(numbered("S_rect_0", n)) && file.numbers(numbered("S_rect_0", n), 2) == size;
    if (is_unrectified && !is_rectified) return from_raw_camera(file, n);
  }
  Calibration calibration = from_projection(file, numbered("P_rect_0", n));
  read_kitti_size(calibration, file, numbered("S_rect_0", n));
  return calibration;
}

}  // namespace

Calibration parse_calibration(std::string_view text, const std::string& name, const CalibrationHints& hints) {
  if (significant_lines(text).empty()) fail_at(name, 0, "is empty: expected a camera calibration");
  Calibration calibration =
      KittiFile::recognises(text) ? from_kitti(KittiFile(text, name), hints) : parse_yaml_calibration(text, name);
  const Camera& camera = calibration.camera;
  if (camera.width > 0) check_principal_point(camera, camera.width, camera.height, {name, 0, "the camera"});
  return calibration;
}

Calibration read_calibration(const std::string& path, const CalibrationHints& hints) {
  return parse_calibration(read_whole_file(path, kLargestFile), path, hints);
}

void match_image_size(Calibration& calibration, int width, int height, const std::string& image) {
  Camera& camera = calibration.camera;
  if (camera.width == 0) {
    check_principal_point(camera, width, height, {calibration.source, 0, "the camera"});
    camera.width = width;
    camera.height = height;
  }
  if (camera.width == width && camera.height == height) return;
  fail_at(calibration.source, 0,
          "is for images of " + std::to_string(camera.width) + "x" + std::to_string(camera.height) + ", but " + image +
              " has " + std::to_string(width) + "x" + std::to_string(height) +
              ": give the calibration of this camera at this size");
}

}  // namespace pavo
