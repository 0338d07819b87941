// `pavo calibrate` on the kernel's uvcvideo: somebody holds a board before the webcam here and there, and the camera is
// found; in YUYV and in MJPG.
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "tests/board_calibration/boards.h"
#include "tests/v4l2_vm/support.h"

namespace pavo::v4l2::test {
namespace {

using pavo::test::BoardPainter;
using pavo::test::kBoard;

const std::string kCalibrateLog = "/tmp/calibrate.log", kFile = "/tmp/found.yaml";

/// Two thirds of what the tests of the calibration itself have, in the webcam's picture.
Camera lens() {
  Camera camera = pavo::test::pinhole();
  camera.width = 320, camera.height = 240;
  for (double* length : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *length *= 2. / 3;
  return camera;
}

std::string pgm_of(const Image& image) {
  std::string file = "P5 " + std::to_string(image.width()) + " " + std::to_string(image.height()) + " 255\n";
  for (int y = 0; y < image.height(); ++y) file.append(reinterpret_cast<const char*>(image.row(y)), image.width());
  return file;
}

int views_taken() {
  const std::string text = text_of(kCalibrateLog);
  int count = 0;
  for (std::size_t at = text.find(" taken, around"); at != std::string::npos; at = text.find(" taken, around", at + 1))
    ++count;
  return count;
}

/// Moves the board from place to place until so many views were taken; it is held wherever it is seen, for as long as
/// this machine needs.
void show_board(Webcam& webcam, const Pavo& calibrating, const std::vector<SE3>& places, int views) {
  const BoardPainter painter(lens());
  std::mt19937 random(1);
  Image image;
  const auto show = [&](const SE3& T_c_b) {
    painter.paint(T_c_b, 2, random, image);
    webcam.show(pgm_of(image));
  };
  ASSERT_TRUE(eventually([&] { return mapped_buffers(calibrating.pid()) > 0; })) << text_of(kCalibrateLog);
  for (std::size_t n = 0; n < places.size() && views_taken() < views; ++n) {
    const int before = views_taken();
    if (n > 0) show({places[n].R, 0.5 * (places[n].t + places[n - 1].t)});
    show(places[n]);
    for (int i = 0; i < 200 && views_taken() == before; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_GE(views_taken(), views);
}

void expect_within_three_sigma(const nlohmann::json& found) {
  const Camera truth = lens();
  const auto& d = truth.distortion;
  for (const auto& [name, value] : std::initializer_list<std::pair<const char*, double>>{{"fx", truth.fx},
                                                                                         {"fy", truth.fy},
                                                                                         {"cx", truth.cx},
                                                                                         {"cy", truth.cy},
                                                                                         {"k1", d[0]},
                                                                                         {"k2", d[1]},
                                                                                         {"p1", d[2]},
                                                                                         {"p2", d[3]},
                                                                                         {"k3", d[4]}}) {
    const auto& parameter = found["parameters"][name];
    const double is = parameter["value"], sigma = parameter["sigma"];
    std::printf("%s %.5g +- %.2g, in truth %.5g\n", name, is, sigma, value);
    EXPECT_LT(std::abs(is - value), 3 * sigma) << name;
  }
}

void expect_lens(const std::string& format, int views) {
  Webcam webcam;
  std::filesystem::remove(kFile);
  Pavo calibrating({"calibrate", kWebcam, "--size", "320x240", "--format", format, "--rate", "15", "--board", "8x6",
                    "--square", "0.03", "--views", std::to_string(views), "--out", kFile},
                   kCalibrateLog);
  show_board(webcam, calibrating, pavo::test::poses(lens(), 4 * views, 1), views);
  ASSERT_EQ(calibrating.wait(), 0) << text_of(kCalibrateLog);
  EXPECT_THAT(text_of(kCalibrateLog), ::testing::HasSubstr("; next: the "));
  EXPECT_TRUE(std::filesystem::exists(kFile));
  expect_within_three_sigma(nlohmann::json::parse(text_of("/tmp/found.json")));
}

TEST(PavoCalibrate, FindsTheLensFromYuyv) {
  expect_lens("YUYV", 8);
}

TEST(PavoCalibrate, FindsTheLensFromMjpeg) {
  expect_lens("MJPG", 8);
}

TEST(PavoCalibrate, EndsAtASignalWhereNoBoardIsSeen) {
  Pavo watching({"calibrate", kVivid, "--size", "320x180", "--board", "9x6", "--out", "/tmp/none.yaml"}, kCalibrateLog);
  ASSERT_TRUE(eventually([&] { return mapped_buffers(watching.pid()) > 0; })) << text_of(kCalibrateLog);
  std::this_thread::sleep_for(std::chrono::seconds(1));  // watches
  watching.send(SIGINT);
  EXPECT_EQ(watching.wait(), 1);
  EXPECT_THAT(text_of(kCalibrateLog), ::testing::HasSubstr("no board of 9x6 inner corners was found"));
  EXPECT_FALSE(std::filesystem::exists("/tmp/none.yaml"));
}

}  // namespace
}  // namespace pavo::v4l2::test
