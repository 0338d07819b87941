// What `pavo run --out DIR` writes while it runs, frame by frame, and what it remembers for the end.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/trajectories/append_file.h"
#include "drivers/trajectories/sync_each_second.h"
#include "drivers/trajectories/trajectory_files.h"
#include "engine/frame_info.h"
#include "pavo/frame.h"
#include "stages/pose/motion_model.h"
#include "tools/pavo/kept_trajectory.h"
#include "tools/pavo/refined_path.h"
#include "types/pose.h"

namespace pavo {

struct PoseCounts {
  std::int64_t tracked = 0, standing = 0, coasting = 0, relocalising = 0;
};
struct PeopleCounts {
  std::int64_t seen = 0;              ///< detections, summed over the frames: the lines of people.csv
  std::int64_t features_dropped = 0;  ///< summed over the frames
  std::int64_t frames_short = 0;      ///< frames in which too few features were left beside the people
};

/// Called by one thread at a time (the delivery). Every file is complete up to the last frame at any moment. Throws
/// std::runtime_error with the path and the system's reason: the run cannot go on then.
class RunOutputs {
 public:
  struct Options {
    std::filesystem::path folder;  ///< empty: nothing is written
    bool people = true;            ///< people.csv
    bool compare = false;          ///< trajectory.geometric.kitti
    bool map = false;              ///< covariance.csv, trajectory.refined.kitti (estimators with a map)
    bool keep_all = true;          ///< false: trajectory() is thinned, so that memory stays flat for days
  };

  /// Makes the folder, and empties the files of an earlier run in it. `time_of` gives the capture time of a frame of
  /// the source that was dropped.
  RunOutputs(const Options& options, std::function<std::int64_t(std::int64_t index)> time_of);

  void deliver(const Frame& frame, const FrameInfo& info, const Outcome& outcome);
  /// No frame comes any more; the source had `frames` of them. Writes the lines of those dropped last, which the end
  /// of the run may have `stopped`, and closes.
  void finish(std::int64_t frames, bool stopped);

  const Trajectory& trajectory() const { return trajectory_.trajectory(); }
  const Trajectory& geometric() const { return geometric_.trajectory(); }
  const PoseCounts& poses() const { return poses_; }
  const PeopleCounts& people() const { return people_; }
  /// The first failure's message, for the warning at the end; "" if nothing failed.
  const std::string& first_failure() const { return first_failure_; }

 private:
  struct Files {
    explicit Files(const Options& options);
    KittiWriter kitti;
    TumWriter tum;
    AppendFile frames;
    std::unique_ptr<AppendFile> people;
    std::unique_ptr<KittiWriter> geometric;
    std::unique_ptr<AppendFile> covariance;
    std::unique_ptr<KittiWriter> refined;
    std::unique_ptr<SyncEachSecond> sync;
  };

  void write_dropped_until(std::int64_t index, std::string_view reason);
  void write_pose(const FrameTime& time, const SE3& T_w_c, const SE3& T_w_c_geometric, bool is_keyframe = false);
  void write_covariance(const Frame& frame, const FrameInfo& info);
  void write_refined();
  void write_frame_line(const Frame& frame, const FrameInfo& info, const Outcome& outcome);
  void write_people(const Frame& frame, const FrameInfo& info);
  void count(const Frame& frame, const FrameInfo& info, const Outcome& outcome);

  Options options_;
  std::function<std::int64_t(std::int64_t)> time_of_;
  std::unique_ptr<Files> files_;
  KeptTrajectory trajectory_, geometric_;
  RefinedPath refined_;
  MotionModel motion_, geometric_motion_;
  FrameTime last_{.index = -1};
  PoseCounts poses_;
  PeopleCounts people_;
  std::string first_failure_;
  std::string line_;
};

}  // namespace pavo
