// A webcam that sends Motion-JPEG, through the kernel's uvcvideo: its bytes arrive as they were sent, are decoded,
// recorded and replayed; broken ones fail alone.
#include <turbojpeg.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/v4l2_vm/support.h"

namespace pavo::v4l2::test {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 320, kHeight = 240;
const std::string kMjpegOut = "/tmp/mjpeg", kMjpegDrive = "/tmp/mjpeg-drive", kMjpegLog = "/tmp/mjpeg.log";

/// A picture with corners in it, as a JPEG.
std::string jpeg(double phase) {
  std::vector<unsigned char> gray;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      gray.push_back(static_cast<unsigned char>(120 + (((x + y / 7) / 16 + y / 16) % 2 ? 60 : -60) +
                                                30 * std::sin(0.05 * x + phase)));
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  tjhandle encoder = tjInitCompress();
  EXPECT_EQ(tjCompress2(encoder, gray.data(), kWidth, 0, kHeight, TJPF_GRAY, &bytes, &size, TJSAMP_GRAY, 90, 0), 0);
  const std::string all(reinterpret_cast<const char*>(bytes), size);
  tjFree(bytes);
  tjDestroy(encoder);
  return all;
}

TEST(Mjpeg, ArrivesAsItWasSent) {
  Webcam webcam;
  Kernel kernel;
  const std::string sent = jpeg(0), other = jpeg(1);
  webcam.show(sent);
  LiveCamera camera(kernel, kWebcam, asking_for({kWidth, kHeight}, 15, "MJPG"));
  EXPECT_EQ(camera.format().pixels.name, "MJPG");
  EXPECT_EQ(camera.format().stride, 0);
  EncodedImage image;
  CameraFrame frame;
  const auto taken = [&] {
    EXPECT_TRUE(camera.wait());
    EXPECT_TRUE(camera.take(image, frame));
    return std::string(image.bytes.begin(), image.bytes.end());
  };
  for (int n = 0; n < 10; ++n) EXPECT_TRUE(taken() == sent) << n << ": " << image.bytes.size() << " bytes";
  EXPECT_EQ(image.encoding, Encoding::file);
  webcam.show(other);
  std::string last;
  for (int n = 0; n < 60 && last != other; ++n) last = taken();
  EXPECT_TRUE(last == other) << "of another length";
  EXPECT_EQ(camera.report().damaged + camera.report().too_short, 0u);
}

std::string failures() {
  const std::string csv = text_of(kMjpegOut + "/frames.csv");
  std::string failed;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);)
    if (line.find("failed") != std::string::npos) failed += line + "\n";
  return failed;
}

std::size_t frames() {
  const std::string text = text_of(kMjpegOut + "/trajectory.kitti");
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

TEST(Mjpeg, RunsFailsFrameByFrameAndGoesOn) {
  Webcam webcam;
  const std::string good = jpeg(0);
  webcam.show(good);
  fs::remove_all(kMjpegOut);
  write_file("/tmp/mjpeg.yaml",
             "image_width: 320\nimage_height: 240\ncamera_name: test\ncamera_matrix: {rows: 3, cols: 3, data: [280, 0, "
             "160, 0, 280, 120, 0, 0, 1]}\ndistortion_model: plumb_bob\ndistortion_coefficients: {rows: 1, cols: 5, "
             "data: [0.1, 0, 0, 0, 0]}\n");
  write_file("/tmp/mjpeg.toml",
             "[features]\nmax_features = 50\n[people]\nenabled = false\n[engine]\nfailures_in_a_row = 1000\n"
             "[device]\nformat = \"MJPG\"\n");
  Pavo run({"run", kWebcam, "--calibration", "/tmp/mjpeg.yaml", "--config", "/tmp/mjpeg.toml", "--rate", "15", "--out",
            kMjpegOut},
           kMjpegLog);
  ASSERT_TRUE(eventually([&] { return frames() > 2; })) << text_of(kMjpegLog);
  webcam.show(good.substr(0, good.size() / 2));
  ASSERT_TRUE(eventually([&] { return failures().find("JPEG: ") != std::string::npos; })) << text_of(kMjpegLog);
  webcam.show(std::string(5000, 'x'));
  ASSERT_TRUE(eventually([&] { return failures().find("expected JPEG, PNG") != std::string::npos; })) << failures();
  webcam.show(good);
  const std::size_t before = frames();
  ASSERT_TRUE(eventually([&] { return frames() > before + 3; })) << text_of(kMjpegLog);
  webcam.pull_out();
  ASSERT_TRUE(eventually([&] { return text_of(kMjpegLog).find("unplugged") != std::string::npos; }))
      << text_of(kMjpegLog);
  webcam.plug_in();
  ASSERT_TRUE(eventually([&] { return text_of(kMjpegLog).find("streams again") != std::string::npos; }))
      << text_of(kMjpegLog);
  run.send(SIGINT);
  ASSERT_EQ(run.wait(), 0) << text_of(kMjpegLog);
  const auto report = nlohmann::json::parse(text_of(kMjpegOut + "/report.json"));
  EXPECT_EQ(report["camera"]["format"], "MJPG");
  EXPECT_GT(report["frames"]["done"], 5);
  EXPECT_GE(report["frames"]["failed"], 2);
  EXPECT_TRUE(report["stages"].contains("decode"));
  EXPECT_EQ(report["frames"]["in"], report["frames"]["done"].get<int>() + report["frames"]["failed"].get<int>() +
                                        report["frames"]["dropped"].get<int>());
}

TEST(Mjpeg, IsRecordedByteForByte) {
  Webcam webcam;
  const std::string sent = jpeg(2);
  webcam.show(sent);
  fs::remove_all(kMjpegDrive);
  ASSERT_EQ(Pavo({"record", kWebcam, "--out", kMjpegDrive, "--format", "MJPG", "--size", "320x240", "--rate", "15",
                  "--frames", "6"},
                 kMjpegLog)
                .wait(),
            0)
      << text_of(kMjpegLog);
  int files = 0;
  for (const auto& entry : fs::directory_iterator(kMjpegDrive + "/mav0/cam0/data")) {
    EXPECT_EQ(entry.path().extension(), ".jpg");
    EXPECT_TRUE(text_of(entry.path()) == sent) << entry.path();
    ++files;
  }
  EXPECT_EQ(files, 6);
}

}  // namespace
}  // namespace pavo::v4l2::test
