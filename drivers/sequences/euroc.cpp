#include "drivers/sequences/directory.h"
#include "drivers/sequences/groundtruth.h"
#include "drivers/sequences/layouts.h"
#include "drivers/sequences/recording.h"
#include "drivers/sequences/stamps.h"
#include "drivers/trajectories/trajectory_files.h"

namespace pavo {
namespace {

namespace fs = std::filesystem;

/// Where the camera is in the body. The sequence's own file knows, also where --calibration gives other intrinsics.
std::optional<SE3> camera_in_body(const fs::path& sensor, const std::optional<Calibration>& calibration) {
  if (calibration && calibration->T_b_c) return calibration->T_b_c;
  return is_file(sensor) ? read_calibration(sensor.string()).T_b_c : std::nullopt;
}

/// EuRoC's own truth, or the same in TUM's format; both are of the body. "" for none.
std::string own_groundtruth(const fs::path& mav) {
  const fs::path estimate = mav / "state_groundtruth_estimate0" / "data.csv";
  const fs::path tum = mav.parent_path() / "groundtruth.tum";
  return is_file(estimate) ? estimate.string() : is_file(tum) ? tum.string() : "";
}

void take_groundtruth_of_body(Recording& recording, const std::string& file, const std::optional<SE3>& T_b_c) {
  if (!T_b_c) {
    recording.info.groundtruth_source = "none: " + file + " is of the body, and no T_BS says where the camera is in it";
    return;
  }
  const Trajectory T_w_b = file.ends_with(".csv") ? read_euroc_groundtruth(file) : read_tum(file);
  set_groundtruth_by_time(recording, camera_of_body(T_w_b, *T_b_c), file);
}

bool is_same_file(const std::string& file, const fs::path& other) {
  std::error_code error;
  return fs::equivalent(file, other, error);
}

}  // namespace

Recording open_euroc(const std::string& source, const fs::path& camera, const SequenceOptions& options) {
  Recording recording;
  recording.info.layout = "EuRoC";
  recording.info.path = source;
  recording.info.has_times = true;
  const std::string index = (camera / "data.csv").string();
  for (const IndexEntry& entry : parse_euroc_index(read_whole_file(index), index)) {
    recording.frames.push_back({(camera / "data" / entry.file).string(), entry.file, entry.t_ns});
  }

  const fs::path sensor = camera / "sensor.yaml";
  const auto T_b_c = camera_in_body(sensor, take_calibration(recording, options, {sensor}));
  const fs::path mav = fs::weakly_canonical(camera).parent_path();
  const std::string own = own_groundtruth(mav);
  if (is_same_file(options.groundtruth, mav.parent_path() / "groundtruth.tum")) {
    take_groundtruth_of_body(recording, options.groundtruth, T_b_c);  // it does not become the camera's by being named
  } else if (take_given_groundtruth(recording, options.groundtruth, T_b_c)) {
    return recording;
  } else if (own.empty()) {
    recording.info.groundtruth_source = "none: no state_groundtruth_estimate0/data.csv in " + mav.string();
  } else {
    take_groundtruth_of_body(recording, own, T_b_c);
  }
  return recording;
}

}  // namespace pavo
