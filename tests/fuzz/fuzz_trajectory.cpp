#include <string_view>

#include "drivers/sequences/groundtruth.h"
#include "drivers/trajectories/speed_file.h"
#include "drivers/trajectories/trajectory_files.h"
#include "tests/fuzz/fuzz.h"

namespace {

using pavo::fuzz::require;

void check_trajectory(const pavo::Trajectory& trajectory) {
  require(!trajectory.T_w_c.empty(), "there is a pose");
  require(trajectory.t_ns.empty() || trajectory.t_ns.size() == trajectory.T_w_c.size(), "one time per pose");
  for (const pavo::SE3& pose : trajectory.T_w_c) {
    require((pose.R.transpose() * pose.R - Eigen::Matrix3d::Identity()).norm() < 1e-3, "poses are rigid motions");
    require(pose.t.allFinite(), "positions are finite");
  }
  for (std::size_t i = 1; i < trajectory.t_ns.size(); ++i) {
    require(trajectory.t_ns[i] > trajectory.t_ns[i - 1], "times increase");
  }
  if (trajectory.t_ns.empty()) return;
  for (const std::int64_t t_ns : trajectory.t_ns) {
    require(pavo::pose_at(trajectory, t_ns).has_value(), "a sample has its own pose");
    pavo::pose_at(trajectory, t_ns / 2);
  }
}

/// What was read can be written and is read again as the same.
void check_round_trip(const pavo::Trajectory& trajectory) {
  check_trajectory(trajectory);
  std::string text;
  for (const pavo::SE3& pose : trajectory.T_w_c) pavo::append_kitti_line(text, pose);
  const pavo::Trajectory again = pavo::parse_kitti_poses(text, pavo::fuzz::kName);
  require(again.T_w_c.size() == trajectory.T_w_c.size(), "as many poses as were written");
  for (std::size_t i = 0; i < again.T_w_c.size(); ++i) {
    const Eigen::Vector3d &a = again.T_w_c[i].t, &b = trajectory.T_w_c[i].t;
    require((a - b).norm() <= 1e-8 * (1 + b.norm()), "the same positions");
    require((again.T_w_c[i].R - trajectory.T_w_c[i].R).norm() < 1e-5, "the same rotations");
  }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace pavo;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  fuzz::try_parse([&] { return parse_trajectory(text, fuzz::kName); }, check_round_trip);
  fuzz::try_parse([&] { return parse_euroc_groundtruth(text, fuzz::kName); }, check_trajectory);
  fuzz::try_parse([&] { return parse_speed(text, fuzz::kName); }, [](const std::vector<SpeedSample>&) {});
  return 0;
}
