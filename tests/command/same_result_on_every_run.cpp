// To the bit: any number of workers, every run, either tracker.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/command/command.h"

namespace pavo::test {
namespace {

std::string sha256_with(const Recording& recording, const std::string& workers, const Words& more) {
  Words words = recording.run({"--workers", workers});
  words.insert(words.end(), more.begin(), more.end());
  const Called called = pavo(words);
  EXPECT_EQ(called.status, 0) << called.error;
  return report_of(recording.out())["trajectory_sha256"];
}

void expect_one_result(int frames, const Words& more) {
  const Recording recording;
  recording.make_long(frames);
  const std::string first = sha256_with(recording, "1", more);
  EXPECT_EQ(first.size(), 64u);
  for (const char* workers : {"1", "2", "3", "4", "8"})
    EXPECT_EQ(sha256_with(recording, workers, more), first) << workers;
}

TEST(SameResult, WithKeyframes) {
  expect_one_result(60, {});
}

TEST(SameResult, WithDescriptors) {
  expect_one_result(60, {"--estimator", "frame-to-frame"});
}

TEST(SameResult, WithKltTracks) {
  expect_one_result(20, {"--tracker", "klt"});  // tens of milliseconds a frame
}

TEST(SameResult, WithFramesThatFail) {
  const Recording recording;
  recording.make_long(60);
  for (const int i : {7, 8, 23, 59}) {
    std::filesystem::remove(recording.image(i));
    std::ofstream(recording.image(i)) << "broken";
  }
  const std::string first = sha256_with(recording, "1", {});
  for (const char* workers : {"2", "8"}) EXPECT_EQ(sha256_with(recording, workers, {}), first) << workers;
}

TEST(SameResult, ButOnlyOfTheSameSeed) {
  const Recording recording;
  const std::string zero = sha256_with(recording, "2", {"--seed", "0"});
  EXPECT_EQ(sha256_with(recording, "2", {}), zero);
  EXPECT_EQ(sha256_with(recording, "2", {"--draw", recording.out("drawn"), "--compare"}), zero);
}

}  // namespace
}  // namespace pavo::test
