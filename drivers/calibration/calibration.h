// Camera calibrations from the files that cameras come with.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "types/camera.h"
#include "types/pose.h"

namespace pavo {

struct Calibration {
  Camera camera;             ///< width = height = 0 where the file does not tell them (KITTI's calib.txt)
  std::string source;        ///< the file, and what in it was used: "seq/calib.txt, P2"
  std::optional<SE3> T_b_c;  ///< of the camera in its body (EuRoC's T_BS), where the file has it
};

/// What the caller knows about the images; it decides between the cameras of one file.
struct CalibrationHints {
  std::optional<int> kitti_camera;  ///< 0..3: which of P0..P3 (image_2: 2); nothing: P0, or the only one that there is
  int width = 0;                    ///< of the images; 0 = unknown
  int height = 0;
};

/// Reads a calibration; its format is recognised from its contents:
/// - KITTI odometry calib.txt: Pn (the images are rectified);
/// - KITTI raw calib_cam_to_cam.txt: P_rect_0n and S_rect_0n, or K_0n, D_0n and S_0n where the images have that size;
/// - EuRoC sensor.yaml: pinhole with radial-tangential or equidistant distortion;
/// - ROS camera_info YAML (plumb_bob, rational_polynomial, equidistant or fisheye): K and D, of the raw image, not P;
/// - OpenCV FileStorage YAML: camera_matrix and distortion_coefficients, in any of their usual spellings.
/// A radial-tangential lens whose coefficients are all zero becomes Lens::rectified.
/// Throws std::runtime_error with one line (file, line, key, what was expected, what to do) for whatever cannot be a
/// calibration: missing keys, wrong counts, NaN, no focal length, skew, a principal point far outside the image,
/// distortion beyond k6. Never guesses. Any thread.
Calibration read_calibration(const std::string& path, const CalibrationHints& hints = {});

/// The same from memory; `name` stands for the file in messages.
Calibration parse_calibration(std::string_view text, const std::string& name, const CalibrationHints& hints = {});

/// Fills the size that the calibration does not have with that of `image`, and throws std::runtime_error where it has
/// another one, or where the principal point is far outside the image.
void match_image_size(Calibration& calibration, int width, int height, const std::string& image);

}  // namespace pavo
