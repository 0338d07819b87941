#include "drivers/sequences/groundtruth.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "drivers/calibration/text.h"
#include "drivers/sequences/recording.h"
#include "drivers/trajectories/append_file.h"
#include "drivers/trajectories/trajectory_files.h"

namespace pavo {
namespace {

SE3 between(const SE3& a, const SE3& b, double share) {
  const Eigen::Quaterniond qa(a.R), qb(b.R);
  return {qa.slerp(share, qb).normalized().toRotationMatrix(), a.t + share * (b.t - a.t)};
}

/// Camera poses far from their origin would lose digits: the first one becomes the identity.
void normalise(Trajectory& trajectory) {
  const SE3 T_c0_w = trajectory.T_w_c.front().inverse();
  for (SE3& pose : trajectory.T_w_c) pose = T_c0_w * pose;
  trajectory.T_w_c.front() = SE3{};
}

bool holds_commas(std::string_view text) {
  const auto lines = significant_lines(text.substr(0, 4096));
  return !lines.empty() && lines.front().text.find(',') != std::string_view::npos;
}

std::string seconds(std::int64_t t_ns) {
  return std::to_string(static_cast<double>(t_ns) * 1e-9);
}

SE3 parse_euroc_pose(const TextLine& line, const std::vector<std::string_view>& fields, const std::string& name) {
  std::array<double, 7> v{};
  for (std::size_t i = 0; i < v.size(); ++i) {
    const auto value = parse_number(fields[i + 1]);
    if (!value || std::abs(*value) > kFarthest_m) {
      fail_at(name, line.number,
              "expected 'nanoseconds, px, py, pz, qw, qx, qy, qz, ...', found " + quoted(fields[i + 1]));
    }
    v[i] = *value;
  }
  const Eigen::Quaterniond q(v[3], v[4], v[5], v[6]);
  if (std::abs(q.norm() - 1) > kQuaternionTolerance) {
    fail_at(name, line.number, "the quaternion has the norm " + std::to_string(q.norm()) + ": expected 1");
  }
  return {q.normalized().toRotationMatrix(), {v[0], v[1], v[2]}};
}

}  // namespace

std::optional<SE3> pose_at(const Trajectory& trajectory, std::int64_t t_ns) {
  const auto& times = trajectory.t_ns;
  const auto after = std::ranges::lower_bound(times, t_ns);
  const auto pose = [&](auto time) { return trajectory.T_w_c[static_cast<std::size_t>(time - times.begin())]; };
  const bool has_after = after != times.end(), has_before = after != times.begin();
  if (has_after && has_before && *after - *(after - 1) <= kLongestGap_ns) {
    const auto before = after - 1;
    return between(pose(before), pose(after),
                   static_cast<double>(t_ns - *before) / static_cast<double>(*after - *before));
  }
  if (has_after && *after - t_ns <= kSameTime_ns) return pose(after);
  if (has_before && t_ns - *(after - 1) <= kSameTime_ns) return pose(after - 1);
  return std::nullopt;
}

Trajectory camera_of_body(Trajectory T_w_b, const SE3& T_b_c) {
  for (SE3& pose : T_w_b.T_w_c) pose = pose * T_b_c;
  return T_w_b;
}

Trajectory parse_euroc_groundtruth(std::string_view text, const std::string& name) {
  Trajectory trajectory;
  for (const TextLine& line : significant_lines(text)) {
    const auto fields = split_fields(line.text, ',');
    std::int64_t t_ns = 0;
    const auto [end, error] = std::from_chars(fields[0].data(), fields[0].data() + fields[0].size(), t_ns);
    if (fields.size() < 8 || error != std::errc{} || end != fields[0].data() + fields[0].size()) {
      fail_at(name, line.number, "expected 'nanoseconds, px, py, pz, qw, qx, qy, qz, ...', found " + quoted(line.text));
    }
    if (!trajectory.t_ns.empty() && t_ns <= trajectory.t_ns.back()) {
      fail_at(name, line.number, "the time does not come after the one before it: expected increasing times");
    }
    trajectory.T_w_c.push_back(parse_euroc_pose(line, fields, name));
    trajectory.t_ns.push_back(t_ns);
  }
  if (trajectory.T_w_c.empty())
    fail_at(name, 0, "has no pose: expected 'nanoseconds, px, py, pz, qw, qx, qy, qz, ...'");
  return trajectory;
}

Trajectory read_euroc_groundtruth(const std::string& path) {
  return parse_euroc_groundtruth(read_whole_file(path), path);
}

void set_groundtruth(Recording& recording, const std::vector<std::optional<SE3>>& pose_of_frame,
                     const std::string& source) {
  SequenceInfo& info = recording.info;
  Trajectory truth;
  info.groundtruth_frames.clear();
  for (std::size_t i = 0; i < recording.frames.size() && i < pose_of_frame.size(); ++i) {
    if (!pose_of_frame[i]) continue;
    truth.T_w_c.push_back(*pose_of_frame[i]);
    if (info.has_times) truth.t_ns.push_back(recording.frames[i].t_ns);
    info.groundtruth_frames.push_back(static_cast<std::int64_t>(i));
  }
  if (truth.T_w_c.empty())
    fail_at(source, 0,
            "has a pose for none of the frames: give the ground truth of this sequence, or --groundtruth none");
  normalise(truth);
  info.groundtruth_source = source;
  if (truth.T_w_c.size() < recording.frames.size()) {
    info.groundtruth_source += " (covers " + std::to_string(truth.T_w_c.size()) + " of the " +
                               std::to_string(recording.frames.size()) + " frames)";
  }
  info.groundtruth = std::move(truth);
}

void set_groundtruth_by_line(Recording& recording, const Trajectory& poses, const std::string& file) {
  const auto line_of_frame = lines_of_frames(recording.frames, poses.T_w_c.size(), file);
  std::vector<std::optional<SE3>> pose_of_frame(recording.frames.size());
  for (std::size_t i = 0; i < pose_of_frame.size(); ++i) {
    if (line_of_frame[i] < poses.T_w_c.size()) pose_of_frame[i] = poses.T_w_c[line_of_frame[i]];
  }
  set_groundtruth(recording, pose_of_frame, file);
}

void set_groundtruth_by_time(Recording& recording, const Trajectory& samples, const std::string& source) {
  if (!recording.info.has_times) {
    fail_at(source, 0,
            "goes by time, and the frames have none: give --rate HZ, or poses in KITTI's format, a line per frame");
  }
  std::vector<std::optional<SE3>> pose_of_frame;
  for (const FrameFile& frame : recording.frames) pose_of_frame.push_back(pose_at(samples, frame.t_ns));
  if (std::ranges::none_of(pose_of_frame, [](const auto& pose) { return pose.has_value(); })) {
    fail_at(source, 0,
            "goes from " + seconds(samples.t_ns.front()) + " s to " + seconds(samples.t_ns.back()) +
                " s, and has no frame of " + seconds(recording.frames.front().t_ns) + " s to " +
                seconds(recording.frames.back().t_ns) +
                " s: give the ground truth of this sequence, or --groundtruth none");
  }
  set_groundtruth(recording, pose_of_frame, source);
}

bool take_given_groundtruth(Recording& recording, const std::string& option, const std::optional<SE3>& T_b_c) {
  if (option.empty()) return false;
  if (option == "none") {
    recording.info.groundtruth_source = "none (--groundtruth none)";
    return true;
  }
  const std::string text = read_whole_file(option);
  if (holds_commas(text)) {
    if (!T_b_c)
      fail_at(option, 0, "is of the body, and where the camera is in it is not known: expected T_BS in sensor.yaml");
    set_groundtruth_by_time(recording, camera_of_body(parse_euroc_groundtruth(text, option), *T_b_c), option);
    return true;
  }
  const Trajectory trajectory = parse_trajectory(text, option);
  if (trajectory.t_ns.empty()) {
    set_groundtruth_by_line(recording, trajectory, option);
  } else {
    set_groundtruth_by_time(recording, trajectory, option);
  }
  return true;
}

}  // namespace pavo
