#include "tools/pavo/run_source.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "drivers/calibration/calibration.h"
#include "pavo/camera_source.h"
#include "pavo/sequence_source.h"
#include "tools/pavo/frame_feed.h"
#include "tools/pavo/open_source.h"
#include "tools/pavo/report.h"
#include "tools/pavo/usage_error.h"

namespace pavo {
namespace {

class SequenceRun final : public RunSource {
 public:
  SequenceRun(const std::string& source, const Config& config, const Clock& clock)
      : sequence_(open_source(source, config)), source_(*sequence_, config.source.mode == "live", clock) {}

  const SequenceInfo& info() const override { return sequence_->info(); }
  void drive(Pipeline<Frame>& pipeline) override { pipeline.run(source_); }
  std::int64_t capture_time_ns(std::int64_t index) const override { return source_.capture_time_ns(index); }
  std::int64_t lines(const Counts& counts) const override { return static_cast<std::int64_t>(counts.in); }
  double rate_hz() const override { return info().rate_hz; }
  std::vector<std::string> warnings() const override {
    const std::int64_t replaced = sequence_->times_replaced();
    if (replaced == 0) return {};
    return {
        fmt::format("{}: {} times are missing or do not increase, and were replaced by the time before and a period",
                    info().path, replaced)};
  }

 private:
  std::unique_ptr<Sequence> sequence_;
  SequenceSource source_;
};

Calibration calibration_of(const std::string& path, const Config& config) {
  if (!config.source.groundtruth.empty() && config.source.groundtruth != "none")
    throw UsageError("--groundtruth " + config.source.groundtruth + ": a camera has no ground truth");
  if (config.source.calibration.empty())
    throw std::runtime_error(path +
                             ": a camera needs its calibration; give it with --calibration FILE, as `pavo calibrate "
                             "DEVICE` makes it");
  return read_calibration(config.source.calibration,
                          {.kitti_camera = {}, .width = config.device.width, .height = config.device.height});
}

v4l2::CameraOptions camera_options(const Config& config, const Camera& camera) {
  constexpr double kSecond_ns = 1e9;
  const bool size_given = config.device.width > 0 && config.device.height > 0;
  v4l2::CameraOptions options{.format = {.size = size_given ? v4l2::FrameSize{config.device.width, config.device.height}
                                                            : v4l2::FrameSize{camera.width, camera.height}},
                              .buffers = config.device.buffers,
                              .controls = v4l2::parse_controls(config.device.controls),
                              .every_frame = config.source.mode == "every-frame",
                              .patience_ns = static_cast<std::int64_t>(config.device.patience_s * kSecond_ns),
                              .give_up_ns = static_cast<std::int64_t>(config.device.give_up_s * kSecond_ns)};
  if (config.source.rate_hz > 0) options.format.rate_hz = config.source.rate_hz;
  if (config.device.format != "auto") options.format.format = config.device.format;
  return options;
}

class CameraRun final : public RunSource {
 public:
  CameraRun(const std::string& path, const Config& config) {
    // What is no camera is told before what it would need.
    (void)v4l2::Device(kernel_, path);
    Calibration calibration = calibration_of(path, config);
    camera_ = std::make_unique<v4l2::LiveCamera>(
        kernel_, path, camera_options(config, calibration.camera),
        [](const std::string& event) { std::fprintf(stderr, "pavo: %s\n", event.c_str()); });
    source_ = std::make_unique<CameraSource>(*camera_);
    const v4l2::FrameSize& size = camera_->format().size;
    match_image_size(calibration, size.width, size.height, path);
    info_.layout = "camera";
    info_.path = path;
    info_.camera = calibration.camera;
    info_.calibration_source = calibration.source;
    info_.groundtruth_source = "none: a camera has no ground truth";
    info_.has_times = true;
  }

  const SequenceInfo& info() const override { return info_; }
  void drive(Pipeline<Frame>& pipeline) override {
    pipeline.run(*source_);
    camera_->rethrow_error();
  }
  // Dropped frames have no lines, so that nobody asks.
  std::int64_t capture_time_ns(std::int64_t) const override { return 0; }
  std::int64_t lines(const Counts& counts) const override {
    return static_cast<std::int64_t>(counts.done + counts.failed);
  }
  double rate_hz() const override { return camera_->format().rate_hz; }

  nlohmann::ordered_json report() const override {
    const v4l2::CameraReport r = camera_->report();
    const v4l2::StampCounts& stamps = r.replaced_stamps;
    const v4l2::CameraReport::Outages& outages = r.outages;
    return {{"name", r.name.card},
            {"driver", r.name.driver},
            {"bus", r.name.bus},
            {"format", r.format.pixels.name},
            {"width", r.format.size.width},
            {"height", r.format.size.height},
            {"rate_hz", r.format.rate_hz},
            {"buffers", r.buffers},
            {"state", r.streaming ? "streaming" : "away"},
            {"dequeued", r.dequeued},
            {"taken", r.taken},
            {"stale", r.stale},
            {"lost_by_driver", r.lost},
            {"damaged", r.damaged},
            {"too_short", r.too_short},
            {"stamped_at", r.stamps_at_start ? "start of frame" : "end of frame"},
            {"stamps_replaced",
             {{"other_clock", stamps.other_clock},
              {"future", stamps.future},
              {"before_start", stamps.before_start},
              {"backwards", stamps.backwards}}},
            {"capture_to_dequeue_ms", quantiles_json(source_->capture_to_dequeue())},
            {"outages",
             {{"hung", outages.hung},
              {"failed", outages.failed},
              {"unplugged", outages.unplugged},
              {"lost", outages.lost},
              {"away_s", static_cast<double>(outages.away_ns) * 1e-9},
              {"longest_return_ms", static_cast<double>(outages.longest_return_ns) * 1e-6}}}};
  }

  std::string summary() const override {
    const v4l2::CameraReport r = camera_->report();
    return fmt::format("{}, {}: {} frames, {} stale, {} lost by the driver, {} damaged", r.name.card, r.format.text(),
                       r.dequeued, r.stale, r.lost, r.damaged + r.too_short);
  }

  std::vector<std::string> warnings() const override {
    const v4l2::CameraReport r = camera_->report();
    std::vector<std::string> all;
    if (r.outages.all() > 0)
      all.push_back(fmt::format("{}: away {} times ({} unplugged, {} failed, {} hung), {:.2f} s in all", info_.path,
                                r.outages.all(), r.outages.unplugged, r.outages.failed, r.outages.hung,
                                static_cast<double>(r.outages.away_ns) * 1e-9));
    if (r.replaced_stamps.all() > 0)
      all.push_back(
          fmt::format("{}: {} of {} frames had a time from the driver that cannot be right; they have the "
                      "time at which they were taken out",
                      info_.path, r.replaced_stamps.all(), r.dequeued));
    return all;
  }

 private:
  v4l2::Kernel kernel_;
  SequenceInfo info_;
  std::unique_ptr<v4l2::LiveCamera> camera_;
  std::unique_ptr<CameraSource> source_;
};

}  // namespace

std::unique_ptr<RunSource> open_run_source(const std::string& source, const Config& config, const Clock& clock) {
  if (is_camera(source)) return std::make_unique<CameraRun>(source, config);
  return std::make_unique<SequenceRun>(source, config, clock);
}

}  // namespace pavo
