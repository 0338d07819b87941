#include <algorithm>
#include <system_error>

#include "drivers/calibration/kitti_file.h"
#include "drivers/calibration/text.h"
#include "drivers/sequences/directory.h"
#include "drivers/sequences/groundtruth.h"
#include "drivers/sequences/layouts.h"
#include "drivers/sequences/oxts.h"
#include "drivers/sequences/recording.h"
#include "drivers/sequences/stamps.h"
#include "drivers/trajectories/append_file.h"

namespace pavo {
namespace {

namespace fs = std::filesystem;

KittiFile read_kitti_file(const fs::path& path) {
  return KittiFile(read_whole_file(path.string()), path.string());
}

/// The rectified camera n in rectified camera 0: P_rect_0n = K [I | t].
SE3 rectified_motion(const KittiFile& file, int camera) {
  const auto p = file.numbers(numbered("P_rect_0", camera), 12);
  if (!(p[0] > 0) || !(p[5] > 0))
    fail_at(file.name(), file.line(numbered("P_rect_0", camera)), "has no positive focal length: expected K [I | t]");
  const SE3 T_n_0{Eigen::Matrix3d::Identity(), {(p[3] - p[2] * p[11]) / p[0], (p[7] - p[6] * p[11]) / p[5], p[11]}};
  return T_n_0 * SE3{file.rotation("R_rect_00"), Eigen::Vector3d::Zero()};
}

/// T_c_imu, through the laser scanner and camera 0.
SE3 imu_in_camera(const fs::path& day, int camera, bool rectified) {
  const SE3 T_velo_imu = read_kitti_file(day / "calib_imu_to_velo.txt").motion("R", "T");
  const SE3 T_0_velo = read_kitti_file(day / "calib_velo_to_cam.txt").motion("R", "T");
  const KittiFile cameras = read_kitti_file(day / "calib_cam_to_cam.txt");
  const SE3 T_c_0 =
      rectified ? rectified_motion(cameras, camera) : cameras.motion(numbered("R_0", camera), numbered("T_0", camera));
  return T_c_0 * T_0_velo * T_velo_imu;
}

/// The records are one per frame, with the frame's number for a name, in a "sync" drive; in an "extract" drive they
/// come at their own rate, and go by time.
struct Oxts {
  std::vector<std::string> names;
  std::vector<OxtsRecord> records;
};

Oxts read_oxts(const fs::path& folder) {
  Oxts oxts;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".txt") oxts.names.push_back(entry.path().filename().string());
  }
  std::ranges::sort(oxts.names, natural_less);
  for (const std::string& name : oxts.names) {
    const std::string path = (folder / name).string();
    oxts.records.push_back(parse_oxts(read_whole_file(path), path));
  }
  return oxts;
}

std::string stem(const std::string& name) {
  return fs::path(name).stem().string();
}

void take_oxts(Recording& recording, const fs::path& drive, const SE3& T_imu_c) {
  const fs::path folder = drive / "oxts" / "data";
  const Oxts oxts = read_oxts(folder);
  if (oxts.records.empty()) {
    recording.info.groundtruth_source = "none: no records in " + folder.string();
    return;
  }
  Trajectory samples;
  for (const OxtsRecord& record : oxts.records) {
    samples.T_w_c.push_back(imu_pose(record, oxts.records.front().latitude_deg) * T_imu_c);
  }
  const fs::path times = drive / "oxts" / "timestamps.txt";
  const bool by_time = oxts.records.size() > recording.frames.size() && recording.info.has_times && is_file(times);
  if (by_time) {
    samples.t_ns = parse_timestamps(read_whole_file(times.string()), times.string());
    if (samples.t_ns.size() != samples.T_w_c.size()) {
      fail_at(times.string(), 0,
              "has " + std::to_string(samples.t_ns.size()) + " times for " + std::to_string(samples.T_w_c.size()) +
                  " records: expected one a line for each");
    }
    set_groundtruth_by_time(recording, samples, folder.string());
    return;
  }
  std::vector<std::optional<SE3>> pose_of_frame(recording.frames.size());
  for (std::size_t i = 0, k = 0; i < pose_of_frame.size() && k < oxts.names.size();) {
    const std::string frame = stem(recording.frames[i].name), record = stem(oxts.names[k]);
    if (frame == record) pose_of_frame[i] = samples.T_w_c[k];
    const bool advance_record = frame == record || natural_less(record, frame);
    i += frame == record || !advance_record ? 1 : 0;
    k += advance_record ? 1 : 0;
  }
  set_groundtruth(recording, pose_of_frame, folder.string());
}

void take_own_groundtruth(Recording& recording, const fs::path& drive, const fs::path& day, int camera) {
  std::vector<fs::path> needed = {drive / "oxts" / "data"};
  for (const char* name : {"calib_imu_to_velo.txt", "calib_velo_to_cam.txt", "calib_cam_to_cam.txt"})
    needed.push_back(day / name);
  for (const fs::path& path : needed) {
    if (is_folder(path) || is_file(path)) continue;
    recording.info.groundtruth_source = "none: no " + path.string();
    return;
  }
  const bool rectified = recording.info.calibration_source.find("before rectification") == std::string::npos;
  take_oxts(recording, drive, imu_in_camera(day, camera, rectified).inverse());
}

}  // namespace

Recording open_kitti_raw(const std::string& source, const fs::path& folder, int camera,
                         const SequenceOptions& options) {
  const fs::path images = folder / numbered("image_0", camera);
  Recording recording = record_images("KITTI raw", source, images / "data");
  const fs::path times = images / "timestamps.txt";
  if (is_file(times))
    take_times(recording, parse_timestamps(read_whole_file(times.string()), times.string()), times.string());
  take_rate(recording, options.rate_hz);

  // The calibrations lie one folder up, with the other drives of the day; a copied drive may have them inside.
  const bool inside = is_file(folder / "calib_cam_to_cam.txt");
  const fs::path day = inside ? folder : fs::weakly_canonical(folder).parent_path();
  take_calibration(recording, options, {day / "calib_cam_to_cam.txt"}, camera);
  if (!take_given_groundtruth(recording, options.groundtruth)) take_own_groundtruth(recording, folder, day, camera);
  return recording;
}

}  // namespace pavo
