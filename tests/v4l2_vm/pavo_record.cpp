// `pavo record` on the kernel's cameras, and what `pavo run` makes of it afterwards.
#include <sstream>

#include <nlohmann/json.hpp>

#include "tests/v4l2_vm/support.h"

namespace pavo::v4l2::test {
namespace {

namespace fs = std::filesystem;

const std::string kDrive = "/tmp/drive", kRecordLog = "/tmp/record.log";

int pavo(std::vector<std::string> words) {
  return Pavo(std::move(words), kRecordLog).wait();
}

void expect_sequence(std::size_t frames) {
  std::istringstream index(text_of(kDrive + "/mav0/cam0/data.csv"));
  std::string line;
  ASSERT_TRUE(std::getline(index, line));
  std::int64_t last_ns = 0;
  std::size_t count = 0;
  for (; std::getline(index, line); ++count) {
    const std::size_t comma = line.find(',');
    const std::int64_t t_ns = std::stoll(line.substr(0, comma));
    EXPECT_GT(t_ns, last_ns);
    last_ns = t_ns;
    EXPECT_TRUE(fs::exists(kDrive + "/mav0/cam0/data/" + line.substr(comma + 1))) << line;
  }
  EXPECT_EQ(count, frames);
}

TEST(PavoRecord, RecordsEveryFormatAsASequenceThatRuns) {
  write_file("/tmp/record.yaml",
             "image_width: 320\nimage_height: 180\ncamera_name: test\ncamera_matrix: {rows: 3, cols: 3, data: [280, 0, "
             "160, 0, 280, 90, 0, 0, 1]}\ndistortion_model: plumb_bob\ndistortion_coefficients: {rows: 1, cols: 5, "
             "data: [0.1, 0, 0, 0, 0]}\n");
  for (const char* format : {"GREY", "YUYV", "NV12"}) {
    fs::remove_all(kDrive);
    ASSERT_EQ(pavo({"record", kVivid, "--out", kDrive, "--calibration", "/tmp/record.yaml", "--format", format,
                    "--rate", "10", "--frames", "12"}),
              0)
        << format << ": " << text_of(kRecordLog);
    expect_sequence(12);
    const auto report = nlohmann::json::parse(text_of(kDrive + "/recording.json"));
    EXPECT_EQ(report["written"], 12);
    EXPECT_EQ(report["no_room"], 0);
  }
  ASSERT_EQ(pavo({"run", kDrive, "--no-people", "--out", "/tmp/replayed"}), 0) << text_of(kRecordLog);
  const auto run = nlohmann::json::parse(text_of("/tmp/replayed/report.json"));
  EXPECT_EQ(run["frames"]["done"], 12);
  EXPECT_THAT(run["source"]["calibration"].get<std::string>(), ::testing::HasSubstr("sensor.yaml"));
}

TEST(PavoRecord, KeepsEveryPixelOfTheWebcam) {
  Webcam webcam;
  std::string picture = "P5\n320 240\n255\n";
  for (int i = 0; i < 320 * 240; ++i) picture += static_cast<char>((i * 7 + i / 320 * 31) % 251);
  webcam.show(picture);
  for (const char* format : {"YUYV", "GREY"}) {
    fs::remove_all(kDrive);
    ASSERT_EQ(pavo({"record", kWebcam, "--out", kDrive, "--size", "320x240", "--format", format, "--rate", "15",
                    "--image", "pgm", "--frames", "4"}),
              0)
        << text_of(kRecordLog);
    expect_sequence(4);
    for (const auto& entry : fs::directory_iterator(kDrive + "/mav0/cam0/data"))
      EXPECT_TRUE(text_of(entry.path()) == picture) << entry.path();
  }
}

TEST(PavoRecord, EndsAtASignalWithAllThatCame) {
  fs::remove_all(kDrive);
  Pavo recording({"record", kVivid, "--out", kDrive, "--size", "320x180", "--rate", "10"}, kRecordLog);
  const auto lines = [] {
    const std::string text = text_of(kDrive + "/mav0/cam0/data.csv");
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  };
  ASSERT_TRUE(eventually([&] { return lines() > 5; })) << text_of(kRecordLog);
  recording.send(SIGINT);
  EXPECT_EQ(recording.wait(), 0) << text_of(kRecordLog);
  EXPECT_THAT(text_of(kRecordLog), ::testing::HasSubstr("no calibration is recorded"));
  expect_sequence(lines() - 1);
}

}  // namespace
}  // namespace pavo::v4l2::test
