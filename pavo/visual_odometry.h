// pavo as a library: push frames, get poses.
//
//     pavo::VisualOdometry odometry(camera, {}, [](const pavo::PoseEstimate& pose) { use(pose); });
//     for (...) odometry.push(gray, stride, t_capture_ns);
//     odometry.finish();
//
// This is the only header, with types/camera.h, that a program needs; it drags nothing else in.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "types/camera.h"

#define PAVO_API __attribute__((visibility("default")))

namespace pavo {

struct PoseEstimate {
  std::int64_t frame = 0;         ///< number of push() calls before the one that this answers
  std::int64_t t_capture_ns = 0;  ///< as it was pushed
  /// Row-major 3x4 [R | t]: maps points of the camera (x right, y down, z forward) to the world, which is the camera's
  /// frame at the first push. Metres where the scale says what a metre is; with "unit" the first baseline (or, frame to
  /// frame, each step) has length 1: a single camera does not see metres.
  std::array<double, 12> T_world_camera{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  std::string quality;  ///< "tracked", "standing" (no motion), "coasting" (the motion model's pose), "relocalising"
  std::string failure;  ///< why this frame has no estimate of its own; "" if it has
  int matches = 0, inliers = 0;
  int people = 0;  ///< whose features were left out
};

struct VisualOdometryOptions {
  std::string config_file;  ///< TOML, see docs/configuration.md; "": defaults
  bool live = false;        ///< push() never waits: a frame for which there is no time is dropped
};

/// One caller's thread pushes; `on_pose` is called by worker threads, for one frame at a time, in order. Throws
/// std::runtime_error and std::invalid_argument with one line that says what is wrong with the camera or the config.
class PAVO_API VisualOdometry {
 public:
  using OnPose = std::function<void(const PoseEstimate&)>;

  VisualOdometry(const Camera& camera, const VisualOdometryOptions& options, OnPose on_pose);
  ~VisualOdometry();  ///< without finish(), frames in flight may get no pose
  VisualOdometry(const VisualOdometry&) = delete;
  VisualOdometry& operator=(const VisualOdometry&) = delete;

  /// Copies camera.width x camera.height gray pixels, rows `stride` bytes apart. Waits until there is room for the
  /// frame; live: returns false at once where there is none. Also false when on_pose has thrown. Throws
  /// std::invalid_argument where `gray` is null or `stride` too small (negative: the image stands on its head).
  bool push(const std::uint8_t* gray, std::ptrdiff_t stride, std::int64_t t_capture_ns);
  /// Waits for the last pose, and throws what on_pose threw. No push() behind it.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pavo
