// What only the caller can mend: status 2, and one line that names the word, what was expected, and the nearest right
// one.
#include "tests/command/command.h"

namespace pavo::test {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

struct WrongCall {
  Words words;
  std::string told;
};

class WrongCalls : public ::testing::Test {
 protected:
  void expect_wrong(const Words& words, const std::string& told) const {
    const Called called = pavo(words);
    const std::string call = ::testing::PrintToString(words);
    EXPECT_EQ(called.status, 2) << call;
    EXPECT_THAT(called.error, AllOf(IsOneLine(), StartsWith("pavo: "), HasSubstr(told))) << call;
    EXPECT_EQ(called.out, "") << call;
    EXPECT_FALSE(std::filesystem::exists(recording.out())) << call;
  }
  Recording recording;
};

TEST_F(WrongCalls, WithoutACommandOrWithAnUnknownOne) {
  expect_wrong({}, "see pavo --help");
  expect_wrong({"rnu", "x"}, "no such command: rnu; did you mean run?");
  expect_wrong({"quaternion"}, "no such command: quaternion; see pavo --help");
  expect_wrong({"--verison"}, "no such option: --verison; did you mean --version?");
  expect_wrong({"run"}, "SOURCE is required; see pavo run --help");
  expect_wrong({"eval", "a"}, "GROUNDTRUTH is required; see pavo eval --help");
  expect_wrong({"synth"}, "--out is required; see pavo synth --help");
}

TEST_F(WrongCalls, UnknownOptionsAreNamedWithTheNearestOne) {
  expect_wrong(recording.run({"--wrokers", "2"}), "no such option: --wrokers; did you mean --workers?");
  expect_wrong(recording.run({"--no-poeple"}), "no such option: --no-poeple; did you mean --no-people?");
  expect_wrong(recording.run({"-j", "4"}), "no such option: -j; see pavo run --help");
  expect_wrong(recording.run({"another"}), "another");
  expect_wrong({"eval", "a", "b", "--plto", "x"}, "no such option: --plto; did you mean --plot?");
  expect_wrong({"synth", "--out", recording.out(), "--sede", "1"}, "no such option: --sede; did you mean --seed?");
}

TEST_F(WrongCalls, ValuesOfTheWrongTypeOrRange) {
  const std::vector<WrongCall> calls{
      {{"--workers", "2.5"}, "--workers must be a whole number from 0 to 256, not '2.5'"},
      {{"--workers", "many"}, "--workers must be a whole number from 0 to 256, not 'many'"},
      {{"--workers", "257"}, "--workers must be a whole number from 0 to 256, not '257'"},
      {{"--workers=-1"}, "--workers must be a whole number from 0 to 256, not '-1'"},
      {{"--workers"}, "--workers"},
      {{"--workers", "1", "--workers", "2"}, "--workers"},
      {{"--seed", "-1"}, "--seed must be a whole number that is not negative, not '-1'"},
      {{"--rate", "fast"}, "--rate must be a number from 0 to 10000, not 'fast'"},
      {{"--rate", "nan"}, "--rate must be a number from 0 to 10000, not 'nan'"},
      {{"--rate", "-10"}, "--rate must be a number from 0 to 10000, not '-10'"},
      {{"--alpha", "1.01"}, "--alpha must be a number from 0 to 1, not '1.01'"},
      {{"--alpha", "inf"}, "--alpha must be a number from 0 to 1, not 'inf'"},
      {{"--estimator", "magic"}, "--estimator must be one of auto, keyframe, frame-to-frame"},
      {{"--tracker", "orb"}, "--tracker must be one of descriptor, klt, not 'orb'"},
      {{"--scale", "miles"},
       "--scale (odometry.scale) must be unit, camera-height[=M], speed=FILE|-|unix:PATH or groundtruth[=FILE], not "
       "'miles'"},
      {{"--scale", "unit=1"}, "not 'unit=1'"},
      {{"--scale", "speed"}, "not 'speed'"},
      {{"--simd", "MMX"}, "this machine has no target 'MMX'; it has: "},
      {{"--live", "--every-frame"}, "--live excludes --every-frame"},
      {{"--draw", ""}, "--draw is empty"},
      {{"--config", ""}, "--config is empty"},
  };
  for (const WrongCall& call : calls) {
    expect_wrong({[&] {
                   Words words{"run", recording.path(), "--no-people"};
                   words.insert(words.end(), call.words.begin(), call.words.end());
                   return words;
                 }()},
                 call.told);
  }
  expect_wrong({"run", recording.path(), "--out", ""}, "--out is empty");
  expect_wrong({"run", ""}, "SOURCE is empty");
}

TEST_F(WrongCalls, TheTrackerIsOfTheOtherEstimator) {
  expect_wrong(recording.run({"--estimator", "keyframe", "--tracker", "klt"}), "--tracker klt");
}

TEST_F(WrongCalls, WhatNeedsTimesSaysHowToGiveThem) {
  recording.remove("times.txt");
  expect_wrong(recording.run({"--live"}), "--live needs the frames' times, and " + recording.path());
  expect_wrong(recording.run({"--scale", "speed=" + recording.file("speed.csv")}), "give them with --rate HZ");
}

TEST_F(WrongCalls, TheSyntheticStreetHasItsOwnCameraAndTruth) {
  expect_wrong({"run", "synthetic", "--calibration", "x"}, "--calibration x: the synthetic street has a camera");
  expect_wrong({"run", "synthetic", "--groundtruth", "x"}, "--groundtruth x: the synthetic street's own, or none");
}

TEST_F(WrongCalls, TheRecordingIsNeverOverwritten) {
  const std::string people = bytes_of(recording.file("people.csv"));
  expect_wrong({"run", recording.path(), "--out", recording.path() + "/."}, "this is SOURCE itself");
  expect_wrong({"run", recording.path(), "--draw", recording.path()}, "this is SOURCE itself");
  EXPECT_EQ(bytes_of(recording.file("people.csv")), people);
}

TEST_F(WrongCalls, SynthRefusesImpossibleStreets) {
  const std::vector<WrongCall> calls{
      {{"--frames", "0"}, "frames is 0, expected 1 to 100000"},
      {{"--frames", "x"}, "--frames"},
      {{"--width", "3"}, "width is 3, expected 16 to 8192"},
      {{"--height", "10000"}, "height is 10000"},
      {{"--speed", "nan"}, "speed_mps is"},
      {{"--noise", "-1"}, "noise_sigma is -1"},
      {{"--hills", "6"}, "hills_m is 6, expected 0 to 5"},
      {{"--hills", "1", "--loop"}, "a loop is level"},
      {{"--density", "9"}, "density is 9"},
      {{"--companions", "31"}, "companions is 31"},
      {{"--lens", "toric"}, "toric"},
      {{"--seed", "-1"}, "--seed"},
  };
  for (const WrongCall& call : calls) {
    Words words{"synth", "--out", recording.out()};
    words.insert(words.end(), call.words.begin(), call.words.end());
    expect_wrong(words, call.told);
  }
}

TEST_F(WrongCalls, HelpAndVersionAreNone) {
  for (const Words& command : std::vector<Words>{{}, {"run"}, {"bench"}, {"eval"}, {"synth"}}) {
    Words help = command, version = command;
    help.push_back("--help");
    version.push_back("--version");
    const Called helped = pavo(help), told = pavo(version);
    EXPECT_EQ(helped.status, 0) << helped.error;
    EXPECT_THAT(helped.out, HasSubstr("Example: pavo ")) << ::testing::PrintToString(command);
    EXPECT_EQ(helped.error, "");
    EXPECT_EQ(told.status, 0) << told.error;
    EXPECT_THAT(told.out, AllOf(IsOneLine(), StartsWith("pavo ")));
  }
}

TEST_F(WrongCalls, AStandardOutputThatIsFullIsAnError) {
  const Called called = pavo(recording.run(), "exec >/dev/full");
  EXPECT_EQ(called.status, 1);
  EXPECT_THAT(called.error, HasSubstr("standard output cannot be written"));
  expect_complete(recording.out());
  EXPECT_EQ(pavo({"--help"}, "exec >/dev/full").status, 1);
}

}  // namespace
}  // namespace pavo::test
