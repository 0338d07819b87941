// `--publish` and `--scale speed=` as a process: with a reader, without one, with a slow one and with one that goes.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/command/command.h"
#include "tests/publishing/sockets.h"

namespace pavo::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

OwnedDescriptor connected_when_there(const std::string& path) {
  for (int i = 0; i < 20000; ++i) {
    if (OwnedDescriptor made = connected_to(path)) return made;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ADD_FAILURE() << path << " never listened";
  return {};
}

TEST(Published, OnStandardOutputIsALineAPoseAndNothingElse) {
  const Recording recording;
  const Called called = pavo(recording.run({"--publish", "-"}));
  EXPECT_EQ(called.status, 0);
  EXPECT_THAT(called.error, HasSubstr("poses: ")) << "the summary";
  const std::vector<std::string> lines = lines_in(called.out);
  ASSERT_EQ(lines.size(), static_cast<std::size_t>(kFrames));
  const auto tum = lines_of(recording.out() + "/trajectory.tum");
  for (int i = 0; i < kFrames; ++i) {
    const auto pose = nlohmann::json::parse(lines[static_cast<std::size_t>(i)]);
    EXPECT_EQ(pose["frame"], i);
    EXPECT_GE(pose["age_ms"].get<double>(), 0);
    double t = 0, x = 0;
    ASSERT_EQ(std::sscanf(tum[static_cast<std::size_t>(i)].c_str(), "%lf %lf", &t, &x), 2);
    EXPECT_NEAR(pose["T_world_camera"]["position"][0].get<double>(), x, 1e-8);
    EXPECT_NEAR(pose["t_capture_ns"].get<double>() * 1e-9, t, 1e-8);
  }
  const auto report = report_of(recording.out());
  EXPECT_EQ(report["publish"]["sent"], kFrames);
  EXPECT_EQ(report["publish"]["lost"], 0);
}

TEST(Published, ASlowReaderLosesLinesAndTheRunGoesOn) {
  const Recording recording;
  recording.make_long(60);
  const std::string pipe = recording.file("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const OwnedDescriptor asleep(::open(pipe.c_str(), O_RDWR | O_NONBLOCK));
  ASSERT_GT(::fcntl(asleep.get(), F_SETPIPE_SZ, 4096), 0);
  const Called called = pavo(recording.run({"--publish", "-"}), "exec >'" + pipe + "'");
  EXPECT_EQ(called.status, 0) << called.error;
  EXPECT_THAT(called.error, HasSubstr("lines were lost"));
  const auto published = report_of(recording.out())["publish"];
  EXPECT_GT(published["lost"].get<int>(), 0);
  EXPECT_EQ(published["lost"].get<int>() + published["sent"].get<int>(), 60);
  expect_complete(recording.out());
}

TEST(Published, AReaderThatVanishesIsNoReasonToEnd) {
  const Recording recording;
  recording.make_long(60);
  const std::string pipe = recording.file("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  Started started(recording.run({"--publish", "-"}), "exec >'" + pipe + "'");
  {
    const OwnedDescriptor reader(::open(pipe.c_str(), O_RDONLY));
    char one = 0;
    EXPECT_EQ(::read(reader.get(), &one, 1), 1);
  }
  EXPECT_EQ(started.wait().status, 0);
  expect_complete(recording.out());
  const auto published = report_of(recording.out())["publish"];
  EXPECT_EQ(published["lines"], 60);
}

TEST(Published, OnASocketReachWhoeverConnects) {
  const Recording recording;
  recording.make_long(100);
  const std::string path = recording.file("poses.sock");
  Started started(recording.run({"--live", "--publish", "unix:" + path}));
  const OwnedDescriptor reader = connected_when_there(path);
  std::string text;
  char block[4096];
  for (ssize_t n; (n = ::recv(reader.get(), block, sizeof block, 0)) > 0;)
    text.append(block, static_cast<std::size_t>(n));
  EXPECT_EQ(started.wait().status, 0);
  EXPECT_GT(lines_in(text).size(), 0u);
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_EQ(report_of(recording.out())["publish"]["readers_ever"], 1);
}

TEST(Published, WrongTargetsAreWrongCalls) {
  const Recording recording;
  for (const char* where : {"tcp:x:5", "udp:x", "unix:", "file"}) {
    const Called called = pavo(recording.run({"--publish", where}));
    EXPECT_EQ(called.status, 2) << where;
    EXPECT_THAT(called.error, AllOf(IsOneLine(), HasSubstr("must be - (standard output), unix:PATH or udp:HOST:PORT")));
  }
  const Called taken = pavo(recording.run({"--publish", "unix:" + recording.file("times.txt")}));
  EXPECT_EQ(taken.status, 1);
  EXPECT_THAT(taken.error, AllOf(IsOneLine(), HasSubstr("no socket")));
}

std::string wheel() {
  std::string csv;
  for (int i = 0; i < 40; ++i) csv += std::to_string(0.05 * i) + "," + std::to_string(7 + 0.1 * i) + "\n";
  return csv;
}

TEST(SpeedOption, ReadsAPipeAsItReadsAFile) {
  const Recording recording;
  recording.write("wheel.csv", wheel());
  const std::string file = recording.file("wheel.csv");
  ASSERT_EQ(pavo(recording.run({"--scale", "speed=" + file})).status, 0);
  const std::string expected = bytes_of(recording.out() + "/trajectory.kitti");
  const Called called = pavo(recording.run({"--scale", "speed=-"}), "exec <'" + file + "'");
  EXPECT_EQ(called.status, 0) << called.error;
  EXPECT_EQ(bytes_of(recording.out() + "/trajectory.kitti"), expected);
  const Called socket = pavo(recording.run({"--scale", "speed=unix:x"}));
  EXPECT_EQ(socket.status, 2);
  EXPECT_THAT(socket.error, AllOf(IsOneLine(), HasSubstr("a socket is for --live")));
}

TEST(SpeedOption, ListensToASocketWhenLive) {
  const Recording recording;
  const std::string path = recording.file("wheel.sock");
  Started started(recording.run({"--live", "--scale", "speed=unix:" + path}));
  const OwnedDescriptor feeder = connected_when_there(path);
  const std::string csv = "# seconds, metres per second\n" + wheel() + "nonsense\n";
  EXPECT_EQ(::send(feeder.get(), csv.data(), csv.size(), MSG_NOSIGNAL), static_cast<ssize_t>(csv.size()));
  EXPECT_EQ(started.wait().status, 0);
  const auto report = report_of(recording.out());
  EXPECT_EQ(report["speed"]["samples"], 40);
  EXPECT_EQ(report["speed"]["refused"], 1);
  EXPECT_THAT(report["scale"].get<std::string>(), HasSubstr("live"));
}

}  // namespace
}  // namespace pavo::test
