#include "tools/pavo/frame_feed.h"

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <filesystem>
#include <mutex>

#include "drivers/calibration/calibration.h"
#include "drivers/sequences/sequence.h"
#include "drivers/v4l2/live_camera.h"
#include "pavo/config.h"
#include "tools/pavo/open_source.h"
#include "tools/pavo/usage_error.h"

namespace pavo {
namespace {

v4l2::FrameSize size_named(const std::string& text) {
  v4l2::FrameSize size;
  int end = 0;
  const bool read = std::sscanf(text.c_str(), "%dx%d%n", &size.width, &size.height, &end) == 2;
  if (!read || end != static_cast<int>(text.size()) || size.width < 1 || size.height < 1 || size.width > 65535 ||
      size.height > 65535)
    throw UsageError("--size must be WIDTHxHEIGHT in pixels, such as 640x480, not '" + text + "'");
  return size;
}

v4l2::CameraOptions wanted_by(const FeedOptions& options) {
  Config config;
  if (!options.config_file.empty()) read_config(options.config_file, config);
  const Config::DeviceSettings& device = config.device;
  constexpr double kSecond_ns = 1e9;
  v4l2::CameraOptions wanted;
  wanted.every_frame = !options.newest;
  wanted.controls = v4l2::parse_controls(options.controls.empty() ? device.controls : options.controls);
  wanted.format.size = {device.width, device.height};
  if (!options.size.empty()) wanted.format.size = size_named(options.size);
  if (options.rate_hz > 0 || config.source.rate_hz > 0)
    wanted.format.rate_hz = options.rate_hz > 0 ? options.rate_hz : config.source.rate_hz;
  wanted.format.format = options.format.empty() && device.format != "auto" ? device.format : options.format;
  wanted.buffers = device.buffers;
  wanted.patience_ns = static_cast<std::int64_t>(device.patience_s * kSecond_ns);
  wanted.give_up_ns = static_cast<std::int64_t>(device.give_up_s * kSecond_ns);
  return wanted;
}

class CameraFeed : public FrameFeed {
 public:
  CameraFeed(v4l2::SystemCalls& system, const std::string& path, const FeedOptions& options) {
    v4l2::CameraOptions wanted = wanted_by(options);
    std::optional<Calibration> calibration;
    if (!options.calibration.empty()) calibration = read_calibration(options.calibration);
    if (calibration && wanted.format.size.width == 0)
      wanted.format.size = {calibration->camera.width, calibration->camera.height};
    live_ = std::make_unique<v4l2::LiveCamera>(
        system, path, wanted, [](const std::string& event) { std::fprintf(stderr, "pavo: %s\n", event.c_str()); });
    const v4l2::FrameSize& size = live_->format().size;
    if (calibration) {
      match_image_size(*calibration, size.width, size.height, path);
      camera_ = calibration->camera;
    }
  }

  const std::optional<Camera>& camera() const override { return camera_; }
  std::string description() const override { return live_->name().card + ", " + live_->format().text(); }

  bool next(EncodedImage& image, std::int64_t& t_ns) override {
    while (live_->wait()) {
      v4l2::CameraFrame frame;
      try {
        if (!live_->take(image, frame)) continue;
      } catch (const v4l2::FrameFault& fault) {
        if (counts_.broken++ == 0) counts_.first_broken = fault.what();
        continue;
      }
      counts_.lost += frame.lost_before;
      ++counts_.taken;
      t_ns = frame.t_sensor_ns;
      return true;
    }
    live_->rethrow_error();
    return false;
  }

  FeedCounts counts() const override {
    FeedCounts counts = counts_;
    counts.passed = live_->report().stale;
    return counts;
  }
  void interrupt() override { live_->interrupt(); }

 private:
  std::optional<Camera> camera_;
  std::unique_ptr<v4l2::LiveCamera> live_;
  FeedCounts counts_;
};

struct OwnKernel {
  v4l2::Kernel kernel;
};

class KernelCameraFeed final : OwnKernel, public CameraFeed {
 public:
  KernelCameraFeed(const std::string& path, const FeedOptions& options) : CameraFeed(kernel, path, options) {}
};

class SequenceFeed final : public FrameFeed {
 public:
  SequenceFeed(const std::string& source, const FeedOptions& options) : paced_(options.paced) {
    for (const auto& [option, value] : {std::pair("--size", options.size), std::pair("--format", options.format),
                                        std::pair("--controls", options.controls)})
      if (!value.empty()) throw UsageError(std::string(option) + " is for cameras, and " + source + " is none");
    Config config;
    config.source.calibration = options.calibration;
    config.source.groundtruth = "none";
    config.source.rate_hz = options.rate_hz;
    sequence_ = open_source(source, config);
    if (!sequence_->info().has_times) throw UsageError(source + ": its frames have no times; give them with --rate HZ");
  }

  const std::optional<Camera>& camera() const override { return sequence_->info().camera; }
  std::string description() const override { return sequence_->info().path + ", " + sequence_->info().layout; }
  std::optional<std::int64_t> frame_count() const override { return sequence_->info().frame_count; }

  bool next(EncodedImage& image, std::int64_t& t_ns) override {
    FrameStamp stamp;
    while (!interrupted_) {
      if (paced_ && !wait_for_its_time()) return false;
      try {
        if (!sequence_->read(image, stamp)) return false;
      } catch (const FrameError& error) {
        if (counts_.broken++ == 0) counts_.first_broken = error.what();
        continue;
      }
      ++counts_.taken;
      t_ns = stamp.t_capture_ns;
      return true;
    }
    return false;
  }

  FeedCounts counts() const override {
    FeedCounts counts = counts_;
    counts.replaced_times = static_cast<std::uint64_t>(sequence_->times_replaced());
    return counts;
  }
  void interrupt() override {
    const std::lock_guard lock(mutex_);
    interrupted_ = true;
    woken_.notify_all();
  }

 private:
  using Clock = std::chrono::steady_clock;

  bool wait_for_its_time() {
    const std::optional<FrameStamp> stamp = sequence_->peek();
    if (!stamp) return false;
    if (!first_ns_) {
      first_ns_ = stamp->t_capture_ns;
      start_ = Clock::now();
    }
    std::unique_lock lock(mutex_);
    return !woken_.wait_until(lock, start_ + std::chrono::nanoseconds(stamp->t_capture_ns - *first_ns_),
                              [this] { return interrupted_.load(); });
  }

  std::unique_ptr<Sequence> sequence_;
  bool paced_;
  std::optional<std::int64_t> first_ns_;
  Clock::time_point start_;
  FeedCounts counts_;
  std::mutex mutex_;
  std::condition_variable woken_;
  std::atomic<bool> interrupted_{false};
};

}  // namespace

void add_feed_options(CLI::App& command, FeedOptions& options) {
  command.add_option("--calibration", options.calibration, "the camera; default: the source's own, if any")
      ->type_name("FILE");
  command.add_option("--rate", options.rate_hz, "of a camera (default 30); or gives times to a source without any")
      ->type_name("HZ")
      ->check(CLI::Range(0.01, 10000.).description(""));
  command.add_option("--config", options.config_file, "a camera's [device], see docs/configuration.md")
      ->type_name("FILE.toml");
  command.add_option("--size", options.size, "of a camera's pictures; default: as it stands")
      ->type_name("WIDTHxHEIGHT");
  command.add_option("--format", options.format, "of a camera's pixels, such as GREY, YUYV, MJPG; default: the best")
      ->type_name("NAME");
  command.add_option("--controls", options.controls, "of a camera: \"auto_exposure=1, exposure_time_absolute=50\"")
      ->type_name("NAME=VALUE,...");
}

bool is_camera(const std::string& source) {
  std::error_code unknown;
  return source.starts_with("/dev/") || std::filesystem::is_character_file(source, unknown);
}

std::unique_ptr<FrameFeed> open_feed(const std::string& source, const FeedOptions& options) {
  if (is_camera(source)) return std::make_unique<KernelCameraFeed>(source, options);
  return std::make_unique<SequenceFeed>(source, options);
}

std::unique_ptr<FrameFeed> open_camera_feed(v4l2::SystemCalls& system, const std::string& path,
                                            const FeedOptions& options) {
  return std::make_unique<CameraFeed>(system, path, options);
}

}  // namespace pavo
