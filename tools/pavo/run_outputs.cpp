#include "tools/pavo/run_outputs.h"

#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <iterator>

#include "tools/pavo/csv_field.h"

namespace pavo {
namespace {

constexpr std::string_view kReplaced = "replaced by a newer frame";

// Exact: a double of seconds since 1970 is off by hundreds of nanoseconds.
std::string seconds_text(std::int64_t t_ns) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  return fmt::format("{}{}.{:09d}", t_ns < 0 ? "-" : "", std::abs(t_ns / kSecond), std::abs(t_ns % kSecond));
}

// The upper triangle, row by row; of a frame's own errors x y z (m) rx ry rz (rad).
std::string covariance_header() {
  constexpr std::array kNames = {"x", "y", "z", "rx", "ry", "rz"};
  std::string line = "frame";
  for (std::size_t i = 0; i < kNames.size(); ++i)
    for (std::size_t j = i; j < kNames.size(); ++j) line += fmt::format(",{}_{}", kNames[i], kNames[j]);
  return line + "\n";
}

std::filesystem::path made(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder))
    throw std::runtime_error("--out " + folder.string() +
                             ": this folder cannot be made: " + (error ? error.message() : "it is no directory"));
  // What an earlier run with other options left would otherwise pass for this run's.
  for (const char* name : {"people.csv", "trajectory.geometric.kitti", "trajectory.refined.kitti", "covariance.csv",
                           "trajectory.svg", "report.json"})
    std::filesystem::remove(folder / name, error);
  return folder;
}

}  // namespace

RunOutputs::Files::Files(const Options& options)
    : kitti(made(options.folder) / "trajectory.kitti"),
      tum(options.folder / "trajectory.tum"),
      frames(options.folder / "frames.csv") {
  frames.append("frame,timestamp_s,status,reason,quality,keypoints,dropped_on_people,matches,inliers\n");
  if (options.people) {
    people = std::make_unique<AppendFile>(options.folder / "people.csv");
    people->append("frame,x,y,width,height,score\n");
  }
  if (options.map) {
    covariance = std::make_unique<AppendFile>(options.folder / "covariance.csv");
    covariance->append(covariance_header());
    refined = std::make_unique<KittiWriter>(options.folder / "trajectory.refined.kitti");
  }
  if (options.compare) geometric = std::make_unique<KittiWriter>(options.folder / "trajectory.geometric.kitti");
  std::vector<std::string> paths;
  for (const char* name : {"trajectory.kitti", "trajectory.tum", "frames.csv", "people.csv",
                           "trajectory.geometric.kitti", "trajectory.refined.kitti", "covariance.csv"})
    paths.push_back(options.folder / name);
  sync = std::make_unique<SyncEachSecond>(paths);
}

RunOutputs::RunOutputs(const Options& options, std::function<std::int64_t(std::int64_t)> time_of)
    : options_(options), time_of_(std::move(time_of)), trajectory_(options.keep_all), geometric_(options.keep_all) {
  if (!options_.folder.empty()) files_ = std::make_unique<Files>(options_);
}

void RunOutputs::deliver(const Frame& frame, const FrameInfo& info, const Outcome& outcome) {
  write_dropped_until(info.source_index, kReplaced);
  write_pose({.index = info.source_index, .t_ns = info.t_capture_ns}, frame.pose.T_w_c,
             options_.compare ? frame.geometric.T_w_c : frame.pose.T_w_c, frame.keyframe.is_keyframe);
  if (options_.map) refined_.adjust(frame.keyframe.adjusted);
  write_refined();
  count(frame, info, outcome);
  if (!files_) return;
  write_frame_line(frame, info, outcome);
  if (files_->covariance) write_covariance(frame, info);
  if (files_->people && !outcome.failed) write_people(frame, info);
}

void RunOutputs::finish(std::int64_t frames, bool stopped) {
  write_dropped_until(frames, stopped ? "the run was stopped" : kReplaced);
  trajectory_.finish();
  geometric_.finish();
  if (!files_) return;
  files_->kitti.close();
  files_->tum.close();
  files_->frames.close();
  if (files_->people) files_->people->close();
  if (files_->geometric) files_->geometric->close();
  if (files_->covariance) files_->covariance->close();
  if (files_->refined) {
    refined_.end();
    write_refined();
    files_->refined->close();
  }
}

// A frame that was dropped before any stage saw it has the motion model's pose, as one that failed.
void RunOutputs::write_dropped_until(std::int64_t index, std::string_view reason) {
  const FrameTime from = last_;
  const MotionModel motion = motion_, geometric_motion = geometric_motion_;
  const SE3 at = trajectory_.last(), geometric_at = geometric_.last();
  while (last_.index + 1 < index) {
    const std::int64_t dropped = last_.index + 1;
    const FrameTime now{.index = dropped, .t_ns = time_of_(dropped)};
    if (files_)
      files_->frames.append(
          fmt::format("{},{},dropped,{},coasting,0,0,0,0\n", dropped, seconds_text(now.t_ns), reason));
    ++poses_.coasting;
    const bool any = from.index >= 0;
    write_pose(now, any ? at * motion.predict(from, now) : at,
               any ? geometric_at * geometric_motion.predict(from, now) : geometric_at);
  }
}

void RunOutputs::write_pose(const FrameTime& time, const SE3& T_w_c, const SE3& T_w_c_geometric, bool is_keyframe) {
  if (options_.map) refined_.add(T_w_c, is_keyframe);
  if (!trajectory_.empty()) {
    motion_.observe(trajectory_.last().inverse() * T_w_c, last_, time);
    if (options_.compare) geometric_motion_.observe(geometric_.last().inverse() * T_w_c_geometric, last_, time);
  }
  last_ = time;
  trajectory_.add(time.t_ns, T_w_c);
  if (options_.compare) geometric_.add(time.t_ns, T_w_c_geometric);
  if (!files_) return;
  files_->kitti.write(T_w_c);
  files_->tum.write(time.t_ns, T_w_c);
  if (files_->geometric) files_->geometric->write(T_w_c_geometric);
}

void RunOutputs::write_covariance(const Frame& frame, const FrameInfo& info) {
  line_ = fmt::format("{}", info.source_index);
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j) fmt::format_to(std::back_inserter(line_), ",{:.6e}", frame.pose.covariance(i, j));
  line_ += '\n';
  files_->covariance->append(line_);
}

void RunOutputs::write_refined() {
  while (const std::optional<SE3> T_w_c = refined_.next_final())
    if (files_ && files_->refined) files_->refined->write(*T_w_c);
}

void RunOutputs::write_frame_line(const Frame& frame, const FrameInfo& info, const Outcome& outcome) {
  const PoseResult& pose = frame.pose;
  const std::string reason =
      outcome.failed ? fmt::format("{}: {}", outcome.stage, outcome.message) : std::string(name_of(pose.reason));
  line_.clear();
  fmt::format_to(std::back_inserter(line_), "{},{},{},{},{},{},{},{},{}\n", info.source_index,
                 seconds_text(info.t_capture_ns), outcome.failed ? "failed" : "done", csv_field(reason),
                 name_of(pose.quality), pose.keypoints, pose.dropped_on_people, pose.matches, pose.inliers);
  files_->frames.append(line_);
}

void RunOutputs::write_people(const Frame& frame, const FrameInfo& info) {
  line_.clear();
  for (const PersonBox& box : frame.detections)
    fmt::format_to(std::back_inserter(line_), "{},{:.1f},{:.1f},{:.1f},{:.1f},{:.4f}\n", info.source_index, box.x,
                   box.y, box.width, box.height, box.score);
  if (!line_.empty()) files_->people->append(line_);
}

void RunOutputs::count(const Frame& frame, const FrameInfo& info, const Outcome& outcome) {
  switch (frame.pose.quality) {
    case Quality::tracked:
      ++poses_.tracked;
      break;
    case Quality::standing:
      ++poses_.standing;
      break;
    case Quality::relocalising:
      ++poses_.relocalising;
      break;
    case Quality::coasting:
      ++poses_.coasting;
  }
  people_.features_dropped += frame.pose.dropped_on_people;
  if (options_.people && !outcome.failed) people_.seen += static_cast<std::int64_t>(frame.detections.size());
  if (frame.pose.reason == PoseReason::too_few_after_people) ++people_.frames_short;
  if (outcome.failed && first_failure_.empty())
    first_failure_ = fmt::format("frame {}{}{} ({}): {}", info.source_index, frame.name.empty() ? "" : ", ", frame.name,
                                 outcome.stage, outcome.message);
}

}  // namespace pavo
