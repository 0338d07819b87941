// A wheel's speed is what makes the trajectory metric: of both estimators, from a file, a pipe and a socket. The
// keyframe estimator takes it through the map's scale.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "drivers/synthetic/write_kitti.h"
#include "tests/command/command.h"
#include "tests/publishing/sockets.h"

namespace pavo::test {
namespace {

using Positions = std::vector<Eigen::Vector3d>;

Positions positions_in(const std::string& kitti) {
  Positions positions;
  for (const std::string& line : lines_of(kitti)) {
    double m[12];
    std::istringstream words(line);
    for (double& value : m) words >> value;
    positions.emplace_back(m[3], m[7], m[11]);
  }
  return positions;
}

double length_of(const Positions& positions) {
  double length = 0;
  for (std::size_t i = 1; i < positions.size(); ++i) length += (positions[i] - positions[i - 1]).norm();
  return length;
}

class SpeedInMetres : public ::testing::TestWithParam<const char*> {
 protected:
  SpeedInMetres() {
    SyntheticOptions options;
    options.frames = 36;
    options.width = 400;
    options.height = 160;
    options.density = 0;
    options.speed_mps = 5;
    write_kitti_folder(options, street);
    const Positions truth = positions_in(street + "/poses.txt");
    for (std::size_t i = 1; i < truth.size(); ++i) {  // in the middle between two frames, which are 0.1 s apart
      const double t = 0.1 * (static_cast<double>(i) - 0.5), v = (truth[i] - truth[i - 1]).norm() / 0.1;
      wheel += std::to_string(t) + "," + std::to_string(v) + "\n";
    }
    length_m = length_of(truth);
  }
  Words run(const std::string& where, const Words& more = {}) const {
    Words words{"run",     street,           "--out",     out, "--no-people", "--estimator", GetParam(),
                "--scale", "speed=" + where, "--workers", "2"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  void expect_metres(double tolerance) const {
    const double found = length_of(positions_in(out + "/trajectory.kitti"));
    EXPECT_NEAR(found / length_m, 1, tolerance) << found << " m for " << length_m << " m";
  }

  TemporaryFolder folder;
  const std::string street = folder.file("street"), out = folder.file("out");
  std::string wheel;
  double length_m = 0;
};

TEST_P(SpeedInMetres, FromAFileAndTheSameFromAPipe) {
  folder.write("wheel.csv", wheel);
  const Called called = pavo(run(folder.file("wheel.csv")));
  ASSERT_EQ(called.status, 0) << called.error;
  expect_metres(0.03);
  const std::string expected = bytes_of(out + "/trajectory.kitti");
  ASSERT_EQ(pavo(run("-"), "exec <'" + folder.file("wheel.csv") + "'").status, 0);
  EXPECT_EQ(bytes_of(out + "/trajectory.kitti"), expected);
}

TEST_P(SpeedInMetres, LiveFromASocket) {
  const std::string path = folder.file("wheel.sock");
  Started started(run("unix:" + path, {"--live"}));
  OwnedDescriptor feeder;
  for (int i = 0; i < 20000 && !feeder; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    feeder = connected_to(path);
  }
  ASSERT_TRUE(feeder);
  EXPECT_EQ(::send(feeder.get(), wheel.data(), wheel.size(), MSG_NOSIGNAL), static_cast<ssize_t>(wheel.size()));
  const Called called = started.wait();
  ASSERT_EQ(called.status, 0) << called.error;
  EXPECT_EQ(report_of(out)["speed"]["samples"], 35);
  expect_metres(0.2);  // a machine that is slow drops frames, over which the motion model goes on
}

INSTANTIATE_TEST_SUITE_P(Estimators, SpeedInMetres, ::testing::Values("frame-to-frame", "keyframe"), [](const auto& i) {
  return std::string(i.param) == "keyframe" ? "Keyframe" : "FrameToFrame";
});

}  // namespace
}  // namespace pavo::test
