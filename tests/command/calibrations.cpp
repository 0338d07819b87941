// `pavo calibrate` and `pavo undistort` as a process.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "drivers/calibration/calibration.h"
#include "tests/board_calibration/boards.h"
#include "tests/command/command.h"

namespace pavo::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

namespace fs = std::filesystem;

cv::Mat as_mat(Image& image) {
  return {image.height(), image.width(), CV_8UC1, image.row(0), static_cast<std::size_t>(image.stride())};
}

/// Pictures of a board, made once.
const std::string& boards() {
  static const TemporaryFolder folder;
  static const std::string path = [] {
    fs::create_directory(folder.file("boards"));
    const BoardPainter painter(pinhole());
    std::mt19937 random(1);
    Image image;
    int n = 0;
    for (const SE3& pose : poses(pinhole(), 8, 1)) {
      painter.paint(pose, 2, random, image);
      cv::imwrite(folder.file("boards/" + std::to_string(n++) + ".png"), as_mat(image));
    }
    return folder.file("boards");
  }();
  return path;
}

class Calibrate : public ::testing::Test {
 protected:
  Called calibrate(const Words& sources, const Words& more = {"--board", "8x6"}) const {
    Words words{"calibrate"};
    words.insert(words.end(), sources.begin(), sources.end());
    words.insert(words.end(), more.begin(), more.end());
    words.insert(words.end(), {"--out", out()});
    return pavo(words);
  }
  void expect_refused(const Called& called, int status, const std::string& told) const {
    EXPECT_EQ(called.status, status);
    EXPECT_THAT(called.error, AllOf(IsOneLine(), StartsWith("pavo: "), HasSubstr(told)));
    EXPECT_FALSE(fs::exists(out()));
  }
  std::string out() const { return folder.file("camera.yaml"); }
  TemporaryFolder folder;
};

TEST_F(Calibrate, WritesACameraAPictureAndAReport) {
  const Called called = calibrate({boards()}, {"--board", "8x6", "--name", "front"});
  EXPECT_EQ(called.status, 0) << called.error;
  EXPECT_THAT(called.out, AllOf(HasSubstr("8 of 8 views of 480x360"), HasSubstr("  fx "), HasSubstr("RMS 0.")));
  const Calibration calibration = read_calibration(out());
  EXPECT_NEAR(calibration.camera.fx, pinhole().fx, 1.5);
  EXPECT_EQ(calibration.camera.lens, Lens::radial_tangential);
  EXPECT_EQ(calibration.camera.width, 480);
  EXPECT_THAT(bytes_of(folder.file("camera.svg")), AllOf(StartsWith("<svg"), HasSubstr("8 views")));
  const auto report = nlohmann::json::parse(bytes_of(folder.file("camera.json")));
  EXPECT_EQ(report["views"].size(), 8u);
  EXPECT_GT(report["parameters"]["fx"]["sigma"].get<double>(), 0);
  EXPECT_LT(report["kept_out_rms_px"].get<double>(), 0.15);
}

TEST_F(Calibrate, TellsPicturesWithoutABoard) {
  const Recording recording;
  cv::imwrite(folder.file("blank.png"), cv::Mat(360, 480, CV_8UC1, cv::Scalar(90)));
  const Called called = calibrate({boards(), folder.file("blank.png")});
  EXPECT_EQ(called.status, 0) << called.error;
  EXPECT_THAT(called.out, HasSubstr("no board  " + folder.file("blank.png")));
}

TEST_F(Calibrate, RefusesWrongCalls) {
  expect_refused(calibrate({boards()}, {}), 2, "--board is required");
  for (const char* board : {"9", "9x", "2x6", "9x6x3", "x", "9x-6", "", "9x1000"})
    expect_refused(calibrate({boards()}, {"--board", board}), 2, "--board");
  expect_refused(calibrate({boards()}, {"--board", "8x6", "--lens", "toric"}), 2, "toric");
  expect_refused(calibrate({boards()}, {"--board", "8x6", "--square", "-1"}), 2, "--square");
  expect_refused(calibrate({boards()}, {"--board", "8x6", "--views", "2"}), 2, "--views");
  expect_refused(calibrate({boards()}, {"--board", "8x6", "--name", "a b"}), 2, "--name");
  expect_refused(calibrate({}, {"--board", "8x6"}), 2, "SOURCE is required");
  expect_refused(calibrate({""}), 2, "a source is empty");
  expect_refused(pavo({"calibrate", boards(), "--board", "8x6", "--out", folder.file("camera.txt")}), 2, ".yaml");
  expect_refused(pavo({"calibrate", boards(), "--board", "8x6"}), 2, "--out is required");
}

TEST_F(Calibrate, RefusesWhatCannotBeRead) {
  expect_refused(calibrate({folder.file("none.png")}), 1, "none.png: no such file");
  expect_refused(calibrate({folder.write("broken.png", "\x89PNG\r\n")}), 1, "broken.png");
  expect_refused(calibrate({folder.write("empty.jpg", "")}), 1, "empty.jpg");
  expect_refused(calibrate({"/dev/null"}), 1, "/dev/null");
  expect_refused(calibrate({boards() + "/0.png"}, {"--board", "9x7"}), 1, "no board of 9x7 inner corners was found");
  expect_refused(calibrate({boards() + "/0.png"}), 1, "expected 3 or more");
  cv::imwrite(folder.file("small.png"), cv::Mat(36, 48, CV_8UC1, cv::Scalar(90)));
  expect_refused(calibrate({boards(), folder.file("small.png")}), 1, "has 48x36, but");
  const Called nowhere = pavo({"calibrate", boards(), "--board", "8x6", "--out", "/nowhere/camera.yaml"});
  EXPECT_EQ(nowhere.status, 1);
  EXPECT_THAT(nowhere.error, AllOf(IsOneLine(), HasSubstr("/nowhere/camera.yaml: cannot be written")));
}

// A camera that watches a board, as a recording plays it: every pose is held for a second.
TEST_F(Calibrate, TakesViewsFromWhatWatchesABoard) {
  fs::create_directories(folder.file("drive/image_0"));
  std::string times;
  for (int frame = 0; frame < 40; ++frame) {
    char name[32];
    std::snprintf(name, sizeof name, "image_0/%06d.png", frame);
    fs::create_symlink(boards() + "/" + std::to_string(frame / 8) + ".png", folder.file(std::string("drive/") + name));
    times += std::to_string(0.1 * frame) + "\n";
  }
  folder.write("drive/times.txt", times);
  const Called called = calibrate({folder.file("drive")});
  EXPECT_EQ(called.status, 0) << called.error;
  EXPECT_THAT(called.out, AllOf(HasSubstr("view 1 taken, around ("), HasSubstr("view 4 taken")));
  EXPECT_NEAR(read_calibration(out()).camera.fx, pinhole().fx, 5);
}

TEST_F(Calibrate, IsUndoneByUndistort) {
  ASSERT_EQ(calibrate({boards()}).status, 0);
  const auto undistort = [&](const Words& more) {
    Words words{"undistort", boards() + "/0.png", "--calibration", out(), "--out", folder.file("straight")};
    words.insert(words.end(), more.begin(), more.end());
    return pavo(words);
  };
  const Called called = undistort({"--compare", "--alpha", "0.5"});
  EXPECT_EQ(called.status, 0) << called.error;
  EXPECT_EQ(read_calibration(folder.file("straight/camera.yaml")).camera.lens, Lens::rectified);
  const cv::Mat straight = cv::imread(folder.file("straight/0.png"), cv::IMREAD_UNCHANGED);
  EXPECT_EQ(straight.size(), cv::Size(480, 360));
  EXPECT_EQ(cv::imread(folder.file("straight/0.compare.png"), cv::IMREAD_UNCHANGED).cols, 968);

  const auto refused = [&](const Called& wrong, int status, const std::string& told) {
    EXPECT_EQ(wrong.status, status);
    EXPECT_THAT(wrong.error, AllOf(IsOneLine(), StartsWith("pavo: "), HasSubstr(told)));
  };
  refused(undistort({"--alpha", "2"}), 2, "--alpha");
  refused(undistort({folder.write("no.png", "x")}), 1, "no.png");
  refused(pavo({"undistort", boards(), "--out", folder.file("x")}), 2, "--calibration is required");
  refused(pavo({"undistort", boards(), "--calibration", folder.file("none"), "--out", folder.file("x")}), 1, "none");
  refused(pavo({"undistort", boards(), "--calibration", out(), "--out", boards()}), 2, "would be overwritten");
  refused(pavo({"undistort", boards(), "--calibration", out(), "--out", out()}), 1, "cannot be made");
  cv::imwrite(folder.file("small.png"), cv::Mat(36, 48, CV_8UC1, cv::Scalar(90)));
  refused(undistort({folder.file("small.png")}), 1, "is for images of 480x360");
}

}  // namespace
}  // namespace pavo::test
