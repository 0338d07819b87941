// Trajectories as files: KITTI's poses and TUM's, read strictly and written as they grow.
//
//   KITTI  one pose a line: the 12 numbers of the row-major 3x4 matrix [R | t] = T_w_c (camera to world), metres.
//          The line's number is the frame's, so a gap or a comment between the poses is an error.
//   TUM    "timestamp tx ty tz qx qy qz qw" a line, seconds and metres, the same T_w_c; lines that start with '#' are
//          comments, blank lines are nothing, the times increase strictly.
//
// Both take any blanks between numbers, CRLF ends and blank lines at the end, whatever the locale. Every error is a
// std::runtime_error of one line: "FILE:LINE: what was expected and what is there". The functions are pure but for the
// file system, so every thread may call them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/trajectories/append_file.h"
#include "types/pose.h"

namespace pavo {

/// How far from a rotation a file's matrix may be: the largest entry of |R^T R - I|. What is off by more than
/// kRotationRounding is replaced by the nearest rotation (in the Frobenius norm), what is nearer stays as it is
/// written.
inline constexpr double kRotationTolerance = 1e-3;
inline constexpr double kRotationRounding = 1e-6;
/// How far a TUM quaternion's norm may be from 1 (files with four decimals exist); it is normalised.
inline constexpr double kQuaternionTolerance = 1e-2;
/// A camera farther from the origin (in any coordinate) is taken for garbage: metres.
inline constexpr double kFarthest_m = 1e9;

/// Throws std::runtime_error where the file cannot be read, has no pose, or a line is not 12 finite numbers whose first
/// 3x3 part is a rotation. `t_ns` is empty.
Trajectory read_kitti_poses(const std::string& path);

/// Throws std::runtime_error where the file cannot be read, has no pose, or a line is not 8 finite numbers with a unit
/// quaternion and a time after the one before it. Times are exact to the nanosecond.
Trajectory read_tum(const std::string& path);

/// Either of the two: the first line that holds anything but a comment tells (12 or 8 numbers).
Trajectory read_trajectory(const std::string& path);

/// KITTI's times.txt: one number of seconds a line, strictly increasing. In nanoseconds, exact.
std::vector<std::int64_t> read_times(const std::string& path);

/// The same on text in memory; `name` stands for the file in messages.
Trajectory parse_kitti_poses(std::string_view text, const std::string& name);
Trajectory parse_tum(std::string_view text, const std::string& name);
Trajectory parse_trajectory(std::string_view text, const std::string& name);
std::vector<std::int64_t> parse_times(std::string_view text, const std::string& name);

/// Appends one line, '\n' included, to `line` (which keeps its capacity): 12 numbers as "%.9e", whatever the locale.
void append_kitti_line(std::string& line, const SE3& T_w_c);
/// Appends "timestamp tx ty tz qx qy qz qw\n": the time with all nine decimals, the others as "%.9e", qw >= 0.
void append_tum_line(std::string& line, std::int64_t t_ns, const SE3& T_w_c);

/// Writes a trajectory while it grows, one complete line per pose. AppendFile says what survives what.
/// Called by one thread; blocks for the file system; allocates nothing after the first line. Throws
/// std::runtime_error, with the path and the system's reason, for every byte that could not be written.
class KittiWriter {
 public:
  explicit KittiWriter(const std::string& path) : file_(path) {}
  void write(const SE3& T_w_c);
  /// Throws where the disk did not take everything. Without it the destructor closes and swallows errors.
  void close() { file_.close(); }

 private:
  AppendFile file_;
  std::string line_;
};

class TumWriter {
 public:
  explicit TumWriter(const std::string& path) : file_(path) {}
  void write(std::int64_t t_ns, const SE3& T_w_c);
  void close() { file_.close(); }

 private:
  AppendFile file_;
  std::string line_;
};

/// Whole trajectories at once. write_tum() throws std::invalid_argument where there is not one time per pose.
void write_kitti_poses(const std::string& path, const Trajectory& trajectory);
void write_tum(const std::string& path, const Trajectory& trajectory);

}  // namespace pavo
