// The layouts that recordings have on disk, one source file each.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "drivers/sequences/image_sequence.h"

namespace pavo {

/// KITTI's odometry benchmark: image_0/ ... image_3/, calib.txt, times.txt; poses.txt beside them, or
/// ../../poses/NN.txt.
Recording open_kitti_odometry(const std::string& source, const std::filesystem::path& folder, int camera,
                              const SequenceOptions& options);

/// "image_0" of camera 2 is "image_02": how KITTI raw numbers its folders, and the keys of its calibration.
inline std::string numbered(std::string name, int camera) {
  name += static_cast<char>('0' + camera);
  return name;
}

/// A drive of KITTI's raw data: image_00/ ... image_03/ with data/ and timestamps.txt, oxts/; the calib_*.txt of the
/// day one folder up.
Recording open_kitti_raw(const std::string& source, const std::filesystem::path& folder, int camera,
                         const SequenceOptions& options);

/// EuRoC (ASL): `camera` is mav0/cam0, with data.csv, data/ and sensor.yaml.
Recording open_euroc(const std::string& source, const std::filesystem::path& camera, const SequenceOptions& options);

/// TUM RGB-D: rgb.txt, groundtruth.txt.
Recording open_tum_rgbd(const std::string& source, const std::filesystem::path& folder, const SequenceOptions& options);

/// Images in `images`, which is `folder` or a folder in it; calibration, times.txt and poses.txt beside, if any.
Recording open_image_folder(const std::string& source, const std::filesystem::path& folder,
                            const std::filesystem::path& images, const SequenceOptions& options);

/// A video file, by OpenCV's videoio.
std::unique_ptr<Sequence> open_video(const std::string& source, const SequenceOptions& options);

}  // namespace pavo
