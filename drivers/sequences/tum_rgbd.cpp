#include <stdexcept>

#include "drivers/sequences/directory.h"
#include "drivers/sequences/groundtruth.h"
#include "drivers/sequences/layouts.h"
#include "drivers/sequences/recording.h"
#include "drivers/sequences/stamps.h"
#include "drivers/trajectories/trajectory_files.h"

namespace pavo {

namespace fs = std::filesystem;

Recording open_tum_rgbd(const std::string& source, const fs::path& folder, const SequenceOptions& options) {
  Recording recording;
  recording.info.layout = "TUM RGB-D";
  recording.info.path = source;
  recording.info.has_times = true;
  const std::string index = (folder / "rgb.txt").string();
  for (const IndexEntry& entry : parse_tum_index(read_whole_file(index), index)) {
    const fs::path file(entry.file);
    recording.frames.push_back({(folder / file).string(), file.filename().string(), entry.t_ns});
  }

  const auto calibration = take_calibration(
      recording, options,
      {folder / "camera.yaml", folder / "camera.yml", folder / "calibration.yaml", folder / "calibration.yml"});
  if (!calibration) {
    throw std::runtime_error(source +
                             ": TUM RGB-D sequences come without a calibration: give the camera's with --calibration "
                             "FILE (ROS or OpenCV YAML)");
  }
  if (take_given_groundtruth(recording, options.groundtruth)) return recording;

  const fs::path truth = folder / "groundtruth.txt";
  if (is_file(truth)) {
    set_groundtruth_by_time(recording, read_tum(truth.string()), truth.string());
  } else {
    recording.info.groundtruth_source = "none: no groundtruth.txt in " + folder.string();
  }
  return recording;
}

}  // namespace pavo
