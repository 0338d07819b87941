#include "drivers/sequences/directory.h"
#include "drivers/sequences/groundtruth.h"
#include "drivers/sequences/layouts.h"
#include "drivers/sequences/recording.h"
#include "drivers/trajectories/trajectory_files.h"

namespace pavo {
namespace {

namespace fs = std::filesystem;

/// poses.txt, or where the benchmark's own download puts it: dataset/poses/05.txt for dataset/sequences/05.
std::string own_poses(const fs::path& folder) {
  if (is_file(folder / "poses.txt")) return (folder / "poses.txt").string();
  const fs::path sequence = fs::weakly_canonical(folder);
  const fs::path official = sequence.parent_path().parent_path() / "poses" / (sequence.filename().string() + ".txt");
  return is_file(official) ? official.string() : "";
}

}  // namespace

Recording open_kitti_odometry(const std::string& source, const fs::path& folder, int camera,
                              const SequenceOptions& options) {
  Recording recording = record_images("KITTI odometry", source, folder / ("image_" + std::to_string(camera)));
  const fs::path times = folder / "times.txt";
  if (is_file(times)) take_times(recording, read_times(times.string()), times.string());
  take_rate(recording, options.rate_hz);
  // KITTI's own file means rectified images; a sequence with a lens, in the same layout, has ROS's instead.
  std::vector<fs::path> calibrations{folder / "calib.txt"};
  if (!is_file(calibrations.front())) calibrations.push_back(folder / "camera.yaml");
  take_calibration(recording, options, calibrations, camera);
  if (take_given_groundtruth(recording, options.groundtruth)) return recording;

  const std::string poses = own_poses(folder);
  if (poses.empty()) {
    recording.info.groundtruth_source = "none: no poses.txt in " + folder.string();
  } else {
    set_groundtruth_by_line(recording, read_kitti_poses(poses), poses);
  }
  return recording;
}

}  // namespace pavo
