// Ctrl-C: what was admitted comes out, every output is written, status 0. Twice: at once.
#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "tests/command/command.h"

namespace pavo::test {
namespace {

class Signalled : public ::testing::Test {
 protected:
  Signalled() { recording.make_long(4000); }

  void expect_drained(int signal, const Words& more = {}) const {
    Started run(recording.run(more));
    ASSERT_TRUE(run.wait_for_lines(recording.out() + "/trajectory.kitti", 3));
    run.send(signal);
    const Called called = run.wait();
    EXPECT_EQ(called.status, 0) << called.error;
    expect_complete(recording.out());
    const auto report = report_of(recording.out());
    EXPECT_GE(report["frames"]["in"], 3);
    EXPECT_LT(report["frames"]["in"], 4000);
  }
  Recording recording;
};

TEST_F(Signalled, InterruptDrains) {
  expect_drained(SIGINT);
}

TEST_F(Signalled, TerminateDrains) {
  expect_drained(SIGTERM, {"--workers", "4"});
}

TEST_F(Signalled, InterruptDrainsALiveRun) {
  expect_drained(SIGINT, {"--live"});
}

TEST_F(Signalled, InterruptDrainsARunThatIsDrawn) {
  expect_drained(SIGINT, {"--draw", recording.out("drawn")});
}

TEST_F(Signalled, TheSecondEndsAtOnce) {
  Started run(recording.run());
  ASSERT_TRUE(run.wait_for_lines(recording.out() + "/trajectory.kitti", 3));
  run.send(SIGSTOP);  // both wait for it when it goes on
  run.send(SIGINT);
  run.send(SIGTERM);
  run.send(SIGCONT);
  EXPECT_EQ(run.wait().status, 130);
}

TEST_F(Signalled, BeforeTheFirstFrameToo) {
  Started run(recording.run());
  run.send(SIGTERM);  // wherever it is, perhaps not even our own process yet
  const int status = run.wait().status;
  EXPECT_TRUE(status == 0 || status == 128 + SIGTERM) << status;
  if (status == 0) expect_complete(recording.out());
}

TEST_F(Signalled, SynthKeepsWhatItHas) {
  Started synth({"synth", "--out", recording.out(), "--width", "320", "--height", "96", "--frames", "20000"});
  ASSERT_TRUE(synth.wait_for_lines(recording.out() + "/times.txt", 3));
  synth.send(SIGINT);
  const Called called = synth.wait();
  EXPECT_EQ(called.status, 0) << called.error;
  const std::size_t frames = lines_of(recording.out() + "/times.txt").size();
  EXPECT_LT(frames, 20000u);
  EXPECT_EQ(lines_of(recording.out() + "/poses.txt").size(), frames);
  const Called again = pavo({"run", recording.out(), "--out", recording.out("replayed"), "--no-people"});
  EXPECT_EQ(again.status, 0) << again.error;
}

}  // namespace
}  // namespace pavo::test
