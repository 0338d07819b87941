// The whole command on the kernel's cameras: every fault while it runs, and a report that tells of them.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "tests/v4l2_vm/support.h"

namespace pavo::v4l2::test {
namespace {

const std::string kRunOut = "/tmp/run", kRunLog = "/tmp/run.log", kMetrics = "/tmp/run.jsonl";

void write_calibration(int width, int height) {
  write_file("/tmp/camera.yaml", "image_width: " + std::to_string(width) + "\nimage_height: " + std::to_string(height) +
                                     "\ncamera_name: test\ncamera_matrix: {rows: 3, cols: 3, data: [280, 0, " +
                                     std::to_string(width / 2) + ", 0, 280, " + std::to_string(height / 2) +
                                     ", 0, 0, 1]}\ndistortion_model: plumb_bob\n"
                                     "distortion_coefficients: {rows: 1, cols: 5, data: [0.1, 0, 0, 0, 0]}\n");
}

struct Running {
  explicit Running(const std::string& node, const std::string& more_config = "", const std::string& give_up_s = "60") {
    std::filesystem::remove_all(kRunOut);
    std::filesystem::remove(kMetrics);
    write_file("/tmp/config.toml",
               "[features]\nmax_features = 50\n[people]\nenabled = false\n[engine]\nworkers = 1\n"
               "live_credits = 1\n[device]\ngive_up_s = " +
                   give_up_s + "\n" + more_config);
    child.emplace(std::vector<std::string>{"run", node, "--calibration", "/tmp/camera.yaml", "--config",
                                           "/tmp/config.toml", "--rate", "10", "--out", kRunOut, "--metrics", kMetrics},
                  kRunLog);
  }
  static std::size_t frames() {
    const std::string text = text_of(kRunOut + "/trajectory.kitti");
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  }
  /// Further frames came through the whole pipeline.
  void expect_more(std::size_t count = 2) {
    const std::size_t now = frames();
    ASSERT_TRUE(eventually([&] { return frames() >= now + count; })) << text_of(kRunLog);
  }
  static std::size_t told(const std::string& what) {
    const std::string text = text_of(kRunLog);
    std::size_t count = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
    return count;
  }
  void expect_recovery(std::size_t outages) {
    ASSERT_TRUE(eventually([&] { return told("streams again") >= outages; })) << text_of(kRunLog);
    expect_more();
  }
  nlohmann::json end() {
    child->send(SIGINT);
    EXPECT_EQ(child->wait(), 0) << text_of(kRunLog);
    return nlohmann::json::parse(text_of(kRunOut + "/report.json"));
  }
  std::optional<Pavo> child;
};

void expect_books(const nlohmann::json& report) {
  const auto& frames = report["frames"];
  EXPECT_EQ(frames["in"], frames["done"].get<int>() + frames["failed"].get<int>() + frames["dropped"].get<int>());
  EXPECT_EQ(frames["in"], report["camera"]["dequeued"]);
  EXPECT_EQ(frames["done"].get<std::size_t>() + frames["failed"].get<std::size_t>(), Running::frames());
}

TEST(PavoRun, SurvivesEveryFaultThatVividHas) {
  write_calibration(320, 180);
  Running run(kVivid, "controls = \"timestamp_source=Start of Exposure\"\n");
  run.expect_more();
  const int descriptors = open_descriptors(run.child->pid()), mapped = mapped_buffers(run.child->pid());
  press("inject_v4l2_buf_flag_error");
  run.expect_more();
  press("inject_vidioc_qbuf_error");
  run.expect_more();
  press("percentage_of_dropped_buffers", "60");
  run.expect_more(8);
  press("percentage_of_dropped_buffers", "0");
  press("inject_fatal_streaming_error");
  run.expect_recovery(1);
  press("inject_vidioc_reqbufs_error");
  press("inject_fatal_streaming_error");
  run.expect_recovery(2);
  press("inject_vidioc_streamon_error");
  press("disconnect");
  run.expect_recovery(3);
  EXPECT_EQ(open_descriptors(run.child->pid()), descriptors);
  EXPECT_EQ(mapped_buffers(run.child->pid()), mapped);

  const nlohmann::json report = run.end();
  expect_books(report);
  const auto& camera = report["camera"];
  EXPECT_EQ(camera["driver"], "vivid");
  EXPECT_EQ(camera["state"], "streaming");
  EXPECT_EQ(camera["damaged"], 1);
  EXPECT_GT(camera["lost_by_driver"], 0);
  EXPECT_EQ(camera["outages"]["failed"], 2);
  EXPECT_EQ(camera["outages"]["unplugged"], 1);
  EXPECT_GT(camera["outages"]["away_s"], 0);
  EXPECT_GT(camera["capture_to_dequeue_ms"]["p50"], 0);
  EXPECT_GE(report["latency_ms"]["end_to_end"]["max"], camera["capture_to_dequeue_ms"]["p50"]) << "from the stamp on";
  EXPECT_GT(report["frames"]["lost_before"], 0);
  EXPECT_EQ(report["config"]["source"]["mode"], "live");
}

TEST(PavoRun, GoesOnEachOfTwentyTimesThatTheWebcamIsPluggedIn) {
  constexpr std::size_t kTimes = 20;
  Webcam webcam;
  write_calibration(320, 240);
  Running run(kWebcam, "format = \"YUYV\"\ncontrols = \"auto_exposure=1, exposure_time_absolute=50\"\n");
  run.expect_more();
  const int descriptors = open_descriptors(run.child->pid()), mapped = mapped_buffers(run.child->pid());
  for (std::size_t n = 1; n <= kTimes; ++n) {
    webcam.pull_out();
    ASSERT_TRUE(eventually([&] { return Running::told("unplugged") >= n; })) << text_of(kRunLog);
    EXPECT_TRUE(eventually([&] { return mapped_buffers(run.child->pid()) == 0; }));
    webcam.plug_in();
    run.expect_recovery(n);
    EXPECT_EQ(open_descriptors(run.child->pid()), descriptors);
    EXPECT_EQ(mapped_buffers(run.child->pid()), mapped);
  }
  const nlohmann::json report = run.end();
  expect_books(report);
  EXPECT_EQ(report["camera"]["driver"], "uvcvideo");
  EXPECT_EQ(report["camera"]["format"], "YUYV");
  EXPECT_EQ(report["camera"]["outages"]["unplugged"], kTimes);
  EXPECT_GE(report["frames"]["lost_before"], kTimes);
  std::printf("pavo run, from the node's return to the first frame, the longest of %zu: %.0f ms\n", kTimes,
              report["camera"]["outages"]["longest_return_ms"].get<double>());
}

TEST(PavoRun, EndsWhenTheCameraStaysAway) {
  Webcam webcam;
  write_calibration(320, 240);
  Running run(kWebcam, "", "1");
  run.expect_more();
  webcam.pull_out();
  EXPECT_EQ(run.child->wait(), 1);
  EXPECT_THAT(text_of(kRunLog), ::testing::HasSubstr("did not come back within 1.00 s"));
  EXPECT_TRUE(std::filesystem::exists(kRunOut + "/report.json")) << "what was computed is written";
}

TEST(PavoRun, EndsAtOnceWhileItWaitsForACamera) {
  Webcam webcam;
  write_calibration(320, 240);
  Running run(kWebcam);
  run.expect_more();
  const auto metrics_say = [](const char* state) {
    return text_of(kMetrics).find("\"state\":\"" + std::string(state) + "\"") != std::string::npos;
  };
  ASSERT_TRUE(eventually([&] { return metrics_say("streaming"); })) << text_of(kMetrics);
  webcam.pull_out();
  ASSERT_TRUE(eventually([&] { return Running::told("unplugged") >= 1; })) << text_of(kRunLog);
  ASSERT_TRUE(eventually([&] { return metrics_say("away"); })) << text_of(kMetrics);
  const nlohmann::json report = run.end();
  expect_books(report);
  EXPECT_EQ(report["camera"]["state"], "away");
}

TEST(PavoDevices, ListsCamerasAndTheirControls) {
  Webcam webcam;
  Pavo listing({"devices", "--json"}, "/tmp/devices.json");
  ASSERT_EQ(listing.wait(), 0) << text_of("/tmp/devices.json");
  const auto devices = nlohmann::json::parse(text_of("/tmp/devices.json"));
  ASSERT_EQ(devices.size(), 4u);
  EXPECT_EQ(devices[0]["driver"], "vivid");
  EXPECT_EQ(devices[2]["driver"], "uvcvideo");
  EXPECT_THAT(devices[3]["problem"].get<std::string>(), ::testing::HasSubstr("metadata"));
  const std::string text = devices[2].dump();
  for (const char* part : {"YUYV", "GREY", "MJPG", "exposure_time_absolute", "640", "30.0"})
    EXPECT_THAT(text, ::testing::HasSubstr(part));
  Pavo table({"devices"}, "/tmp/devices.txt");
  ASSERT_EQ(table.wait(), 0);
  std::printf("%s", text_of("/tmp/devices.txt").c_str());
}

}  // namespace
}  // namespace pavo::v4l2::test
