// A published pose says what the pose is.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "drivers/publishing/pose_line.h"
#include "drivers/publishing/publisher.h"

namespace pavo {
namespace {

TEST(PoseLines, SayWhatThePoseIs) {
  const Eigen::Quaterniond q = Eigen::Quaterniond(-0.5, 0.1, -0.7, 0.3).normalized();
  PublishedPose pose{.frame = 7, .t_capture_ns = 123456789012345678, .age_ms = 4.24242, .quality = "tracked"};
  pose.T_world_camera = {q.toRotationMatrix(), {1. / 3, -2e-7, 1e5}};
  std::string line = "kept ";
  append_pose_line(line, pose);
  ASSERT_EQ(line.back(), '\n');
  EXPECT_EQ(line.find('\n'), line.size() - 1);
  EXPECT_LT(line.size(), kLongestLine);
  const auto json = nlohmann::json::parse(line.substr(5));
  EXPECT_EQ(json.size(), 5u);
  EXPECT_EQ(json["frame"], 7);
  EXPECT_EQ(json["t_capture_ns"].get<std::int64_t>(), 123456789012345678);
  EXPECT_EQ(json["age_ms"].get<double>(), 4.242);
  EXPECT_EQ(json["quality"], "tracked");
  const auto& T = json["T_world_camera"];
  for (int i = 0; i < 3; ++i) EXPECT_EQ(T["position"][i].get<double>(), pose.T_world_camera.t(i));
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(T["quaternion"][i].get<double>(), -q.coeffs()(i), 1e-12) << "w >= 0";
}

}  // namespace
}  // namespace pavo
