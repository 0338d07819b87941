// Ground truth for the frames of a recording.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/sequences/image_sequence.h"
#include "types/pose.h"

namespace pavo {

/// Samples farther apart than this are not interpolated between: the frames there have no truth.
inline constexpr std::int64_t kLongestGap_ns = 500'000'000;
/// A frame this near to a sample has its pose: files round their times.
inline constexpr std::int64_t kSameTime_ns = 100'000;

/// The pose at `t_ns` between the samples of a trajectory with increasing times: t linear, R along the shortest arc.
/// Nothing before the first sample, behind the last, or inside a gap.
std::optional<SE3> pose_at(const Trajectory& trajectory, std::int64_t t_ns);

/// T_w_c = T_w_b T_b_c for every pose.
Trajectory camera_of_body(Trajectory T_w_b, const SE3& T_b_c);

/// EuRoC's state_groundtruth_estimate0/data.csv (nanoseconds, p_w_b, q_w_b as w x y z, and more): T_w_b.
/// Throws std::runtime_error("NAME:LINE: ...").
Trajectory parse_euroc_groundtruth(std::string_view text, const std::string& name);
Trajectory read_euroc_groundtruth(const std::string& path);

/// Each of these sets groundtruth, groundtruth_frames and groundtruth_source of the recording, normalised so that the
/// first pose is the identity. They throw std::runtime_error where no frame has a pose.
void set_groundtruth(Recording& recording, const std::vector<std::optional<SE3>>& pose_of_frame,
                     const std::string& source);
void set_groundtruth_by_line(Recording& recording, const Trajectory& poses, const std::string& file);
void set_groundtruth_by_time(Recording& recording, const Trajectory& samples, const std::string& source);

/// Does what --groundtruth asks for; false where it asks for nothing, so that the sequence's own is to be taken.
/// `T_b_c` serves files that hold the body's poses.
bool take_given_groundtruth(Recording& recording, const std::string& option, const std::optional<SE3>& T_b_c = {});

}  // namespace pavo
