// A source, a calibration, times, a truth or a speed that cannot be used: status 1, one line that names the file (and
// the line in it), and nothing is written.
#include "tests/command/command.h"

namespace pavo::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

namespace fs = std::filesystem;

class Sources : public ::testing::Test {
 protected:
  void expect_error(const Words& words, const std::string& file, const std::string& told) const {
    const Called called = pavo(words);
    EXPECT_EQ(called.status, 1) << ::testing::PrintToString(words);
    EXPECT_THAT(called.error, AllOf(IsOneLine(), StartsWith("pavo: "), HasSubstr(file), HasSubstr(told)));
    EXPECT_EQ(called.out, "");
    EXPECT_FALSE(fs::exists(recording.out()));
  }
  void expect_error(const std::string& file, const std::string& told, const Words& more = {}) const {
    expect_error(recording.run(more), file.empty() ? recording.path() : recording.file(file), told);
  }
  Recording recording;
};

TEST_F(Sources, NoneOrNothingInIt) {
  const TemporaryFolder folder;
  expect_error({"run", folder.file("none"), "--out", recording.out()}, folder.file("none"), "does not exist");
  expect_error({"run", folder.file(""), "--out", recording.out()}, folder.file(""), "is empty");
  folder.write("readme.txt", "hello");
  expect_error({"run", folder.file(""), "--out", recording.out()}, folder.file(""), "looked for image_0/");
  expect_error({"run", folder.file("readme.txt"), "--out", recording.out()}, folder.file("readme.txt"), "no video");
  expect_error({"run", "/dev/null", "--out", recording.out()}, "/dev/null", "is no camera");
  expect_error({"run", "/dev/video-none", "--out", recording.out()}, "/dev/video-none", "there is no such device");
  expect_error({"run", recording.image(0), "--out", recording.out()}, recording.image(0), "is a single image");
  recording.remove("image_0");
  fs::create_directory(recording.file("image_0"));
  expect_error("image_0", "has no images");
}

TEST_F(Sources, ACalibrationThatIsMissingMalformedOrNotFinite) {
  const std::string calibration = bytes_of(recording.file("calib.txt"));
  recording.remove("calib.txt");
  recording.remove("camera.yaml");
  expect_error("", "no calibration was found");
  expect_error("", "--calibration FILE");
  recording.write("calib.txt", "");
  expect_error("calib.txt", "expected");
  recording.write("calib.txt", "P0: 1 2 3\n");
  expect_error("calib.txt:1", "P0 has 3 values: expected");
  recording.write("calib.txt", "P0: nan 0 160 0 0 185 47 0 0 0 1 0\n");
  expect_error("calib.txt:1", "'nan'");
  recording.write("calib.txt", "P0: 0 0 160 0 0 0 47 0 0 0 1 0\n");
  expect_error("calib.txt", "expected");
  recording.write("calib.txt", calibration);
  expect_error("none.yaml", "No such file", {"--calibration", recording.file("none.yaml")});
  expect_error("", "directory", {"--calibration", recording.path()});
  recording.write("big.yaml",
                  "image_width: 640\nimage_height: 480\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
                  "  data: [400, 0, 320, 0, 400, 240, 0, 0, 1]\ndistortion_model: plumb_bob\n"
                  "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0, 0, 0, 0, 0]\n");
  expect_error("big.yaml", "640x480", {"--calibration", recording.file("big.yaml")});
}

TEST_F(Sources, TimesThatAreTooFewOrRunBackwards) {
  recording.write("times.txt", "0\n0.1\n0.2\n");
  expect_error("times.txt", "has 3 times for 12 images");
  recording.write("times.txt", "0\n1\n2\n3\n2.5\n5\n6\n7\n8\n9\n10\n11\n");
  expect_error("times.txt:5", "does not come after the one before it");
  recording.write("times.txt", "0\n1\nnoon\n3\n4\n5\n6\n7\n8\n9\n10\n11\n");
  expect_error("times.txt:3", "noon");
}

TEST_F(Sources, ATruthThatIsMissingOrMalformed) {
  expect_error("none.txt", "No such file", {"--groundtruth", recording.file("none.txt")});
  expect_error("none.txt", "No such file", {"--scale", "groundtruth=" + recording.file("none.txt")});
  recording.write("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0\n");
  expect_error("poses.txt:2", "expected");
  recording.remove("poses.txt");
  expect_error("", "has no ground truth of its own", {"--scale", "groundtruth"});
}

TEST_F(Sources, ASpeedThatIsMissingOrMalformed) {
  const Words scale{"--scale", "speed=" + recording.file("speed.csv")};
  expect_error("speed.csv", "No such file", scale);
  recording.write("speed.csv", "t,v\n0,8\nsoon,8\n");
  expect_error("speed.csv:3", "expected two finite numbers", scale);
  recording.write("speed.csv", "0,8\n1,inf\n");
  expect_error("speed.csv:2", "expected two finite numbers", scale);
  recording.write("speed.csv", "0,8\n1,8\n1,8\n");
  expect_error("speed.csv:3", "must increase", scale);
  recording.write("speed.csv", "");
  expect_error("speed.csv", "holds no speed", scale);
}

TEST_F(Sources, AConfigWithAWrongKeyOrValue) {
  const Words config{"--config", recording.file("c.toml")};
  expect_error("c.toml", "No such file", config);
  recording.write("c.toml", "[engine]\n\nwrokers = 2\n");
  expect_error("c.toml:3", "no such key: engine.wrokers; did you mean engine.workers?", config);
  recording.write("c.toml", "[engine]\nworkers = \"two\"\n");
  expect_error("c.toml:2", "engine.workers must be a whole number from 0 to 256", config);
  recording.write("c.toml", "[engine\n");
  expect_error("c.toml:1", "not TOML", config);
}

TEST_F(Sources, EvalNamesTheFileAndTheLine) {
  const std::string truth = recording.file("poses.txt");
  expect_error({"eval", recording.file("none"), truth}, recording.file("none"), "No such file");
  recording.write("bad.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 x 0 1 0 0 0 0 1 0\n");
  expect_error({"eval", recording.file("bad.txt"), truth}, "bad.txt:2", "expected");
  recording.write("one.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  expect_error({"eval", recording.file("one.txt"), truth}, recording.file("one.txt"), "12");
  expect_error({"eval", truth, truth, "--json", recording.file("no/e.json")}, "no/e.json", "No such file");
}

TEST_F(Sources, SynthLeavesAFolderThatIsInUseAlone) {
  expect_error({"synth", "--out", recording.path(), "--frames", "1"}, recording.path(), "is not empty");
  expect_error({"synth", "--out", recording.file("calib.txt"), "--frames", "1"}, "calib.txt", "folder");
}

}  // namespace
}  // namespace pavo::test
