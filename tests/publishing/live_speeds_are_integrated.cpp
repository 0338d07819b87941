// A wheel's speed that arrives while the run goes on gives the same metres as the same speeds in a file.
#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <random>
#include <thread>

#include "drivers/publishing/live_speed.h"
#include "stages/pose/scale.h"
#include "tests/publishing/sockets.h"
#include "tests/support/temporary.h"

namespace pavo::test {
namespace {

using ::testing::HasSubstr;

constexpr std::int64_t kSecond = 1'000'000'000;

TEST(SpeedHistory, AgreesWithTheFileOfTheSameSpeeds) {
  std::mt19937 random(1);
  SpeedHistory live;
  std::vector<SpeedStep::Sample> samples;
  for (std::int64_t t = 10 * kSecond; t < 20 * kSecond; t += 20'000'000 + random() % 50'000'000) {
    const double v = static_cast<double>(random() % 1000) / 100 - 2;
    samples.push_back({t, v});
    EXPECT_TRUE(live.add({t, v}));
  }
  EXPECT_FALSE(live.add({samples.back().t_ns, 1}));
  const SpeedStep file(samples);
  for (int i = 0; i < 1000; ++i) {
    const std::int64_t from = 9 * kSecond + static_cast<std::int64_t>(random() % 120) * kSecond / 10;
    const std::int64_t to = from + kSecond / 7;
    const double expected = file.metres({.t_from_ns = from, .t_still_until_ns = from, .t_to_ns = to});
    const double got = live.distance_m(from, to);
    EXPECT_EQ(std::isnan(expected), std::isnan(got)) << from;
    if (std::isnan(expected)) continue;
    EXPECT_NEAR(got, expected, 1e-9) << from;
  }
}

TEST(SpeedHistory, KnowsNothingWithoutSamples) {
  EXPECT_TRUE(std::isnan(SpeedHistory().distance_m(0, 1)));
}

TEST(SpeedHistory, ForgetsTheOldestAndKeepsTheRest) {
  SpeedHistory history;
  const auto n = static_cast<std::int64_t>(SpeedHistory::kMost) + 100;
  for (std::int64_t i = 0; i < n; ++i) history.add({i * kSecond / 100, 2});
  EXPECT_TRUE(std::isnan(history.distance_m(0, kSecond / 100)));
  EXPECT_NEAR(history.distance_m((n - 200) * kSecond / 100, (n - 100) * kSecond / 100), 2, 1e-9);
  EXPECT_NEAR(history.distance_m(2 * kSecond, (n - 1) * kSecond / 100), 2 * static_cast<double>(n - 201) / 100, 1e-6);
}

class SpeedSocket : public ::testing::Test {
 protected:
  static void feed(const OwnedDescriptor& to, const std::string& text) {
    ASSERT_EQ(::send(to.get(), text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
  }
  void wait_for(std::uint64_t lines) const {
    for (int i = 0; i < 5000; ++i) {
      const SpeedCounts c = speed.counts();
      if (c.samples + c.refused >= lines) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ADD_FAILURE() << "no " << lines << " lines came";
  }
  TemporaryFolder folder;
  const std::string path = folder.file("wheel");
  LiveSpeed speed{"unix:" + path};
};

TEST_F(SpeedSocket, TakesLinesInAnyPieces) {
  const OwnedDescriptor wheel = connected_to(path);
  feed(wheel, "t,m/s\n1.0,2");
  feed(wheel, "\r\n\n# a comment\n2.0,4\n3");
  feed(wheel, ".0,4\n");
  wait_for(4);
  EXPECT_EQ(speed.counts().samples, 3u);
  EXPECT_EQ(speed.counts().refused, 1u) << "the header";
  EXPECT_NEAR(speed.distance_m(kSecond, 2 * kSecond), 3, 1e-12);
  EXPECT_NEAR(speed.distance_m(2 * kSecond, 3 * kSecond + kSecond / 2), 6, 1e-12);
  EXPECT_TRUE(std::isnan(speed.distance_m(2 * kSecond, 4 * kSecond)));
}

TEST_F(SpeedSocket, CountsWhatIsNoSpeed) {
  const OwnedDescriptor wheel = connected_to(path);
  feed(wheel, "5,1\n4,1\nnan,1\n6,inf\n7\n8,1e300\n" + std::string(100'000, 'x') + "\n9,1\n");
  wait_for(8);
  EXPECT_EQ(speed.counts().samples, 2u);
  EXPECT_EQ(speed.counts().refused, 6u);
  EXPECT_EQ(speed.counts().first_refused, "4,1");
}

TEST_F(SpeedSocket, OutlivesWhoeverFeedsIt) {
  { feed(connected_to(path), "1,1\n2,1"); }
  wait_for(2);
  { const OwnedDescriptor silent = connected_to(path); }
  feed(connected_to(path), "3,1\n");
  wait_for(3);
  EXPECT_NEAR(speed.distance_m(kSecond, 3 * kSecond), 2, 1e-12);
}

TEST(LiveSpeed, RefusesOtherPlaces) {
  EXPECT_THAT(complaint([] { LiveSpeed("tcp:5"); }), HasSubstr("--scale speed=tcp:5: expected -"));
  EXPECT_THAT(complaint([] { LiveSpeed("unix:/no/such/folder/wheel"); }), HasSubstr("cannot be made"));
}

}  // namespace
}  // namespace pavo::test
