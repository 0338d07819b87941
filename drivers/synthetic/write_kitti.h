// The synthetic street as a folder in the layout of KITTI's odometry benchmark.
#pragma once

#include <functional>
#include <string>

#include "drivers/synthetic/options.h"

namespace pavo {

/// Called after every frame; false stops: the folder then holds the frames so far, and is as complete as a whole one.
using WriteProgress = std::function<bool(int frames_written, int frames)>;

/// Writes into `out_dir`, which must not exist or be empty (its parents are made):
/// - image_0/000000.png, ...: 8-bit gray;
/// - times.txt: seconds;  poses.txt: T_w_c in KITTI's form, of every frame;
/// - people.csv: `image,x,y,width,height,ignore`, the box of the whole body, hidden or not, of everybody of whom at
///   least a twentieth can be seen; ignore = 1 where it is less than half. A frame without people: the name alone;
/// - calib.txt: P0 to P3, all of the one camera, where the lens is rectified. KITTI's format means rectified images, so
///   with a lens there is none, but
/// - camera.yaml: the camera as ROS's camera_info (always); where there is no calib.txt, it is what is read.
/// Returns the number of frames. Blocks; renders with options.threads. Throws std::invalid_argument on bad options and
/// std::runtime_error, one line with the path and the reason, where something cannot be written (no room, no right).
int write_kitti_folder(const SyntheticOptions& options, const std::string& out_dir, const WriteProgress& progress = {});

}  // namespace pavo
