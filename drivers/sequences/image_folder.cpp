#include "drivers/sequences/directory.h"
#include "drivers/sequences/groundtruth.h"
#include "drivers/sequences/layouts.h"
#include "drivers/sequences/recording.h"
#include "drivers/trajectories/trajectory_files.h"

namespace pavo {

namespace fs = std::filesystem;

Recording open_image_folder(const std::string& source, const fs::path& folder, const fs::path& images,
                            const SequenceOptions& options) {
  Recording recording = record_images("images", source, images);
  const fs::path times = folder / "times.txt";
  if (is_file(times)) take_times(recording, read_times(times.string()), times.string());
  take_rate(recording, options.rate_hz);

  std::vector<fs::path> candidates;
  for (const char* name : {"calib.txt", "calibration.yaml", "calibration.yml", "camera.yaml", "camera.yml",
                           "camera_info.yaml", "sensor.yaml"}) {
    candidates.push_back(folder / name);
  }
  take_calibration(recording, options, candidates);
  if (take_given_groundtruth(recording, options.groundtruth)) return recording;

  const fs::path poses = folder / "poses.txt";
  if (is_file(poses)) {
    set_groundtruth_by_line(recording, read_kitti_poses(poses.string()), poses.string());
  } else {
    recording.info.groundtruth_source = "none: no poses.txt in " + folder.string();
  }
  return recording;
}

}  // namespace pavo
