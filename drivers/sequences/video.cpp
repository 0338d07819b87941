#include <atomic>
#include <cmath>
#include <filesystem>
#include <opencv2/videoio.hpp>

#include "drivers/calibration/calibration.h"
#include "drivers/calibration/text.h"
#include "drivers/sequences/directory.h"
#include "drivers/sequences/groundtruth.h"
#include "drivers/sequences/layouts.h"
#include "drivers/trajectories/trajectory_files.h"

namespace pavo {
namespace {

namespace fs = std::filesystem;

constexpr double kHighestRate_hz = 1000;

/// Frames as OpenCV decodes them, straight into the caller's memory. Decoding is the container's business here, and
/// what it allocates too.
class VideoSequence final : public Sequence {
 public:
  VideoSequence(const cv::VideoCapture& video, SequenceInfo info, int width, int height)
      : video_(video), info_(std::move(info)), width_(width), height_(height) {}

  const SequenceInfo& info() const override { return info_; }

  std::optional<FrameStamp> peek() override {
    if (!grab()) return std::nullopt;
    return next_;
  }

  bool read(EncodedImage& image, FrameStamp& stamp) override {
    if (!grab()) return false;
    stamp.index = next_.index;
    stamp.t_capture_ns = next_.t_capture_ns;
    stamp.name = next_.name;
    grabbed_ = false;
    if (ends_early_) {
      at_end_ = true;
      throw FrameError(info_.path + ": ends after " + std::to_string(next_.index) + " of " +
                       std::to_string(*info_.frame_count) + " frames: the file is cut or corrupt");
    }
    retrieve(image);
    return true;
  }

  bool skip() override {
    if (!grab()) return false;
    grabbed_ = false;
    at_end_ = ends_early_;
    return true;
  }

  std::int64_t times_replaced() const override { return times_replaced_; }

 private:
  /// Makes `next_` the frame that read() will deliver; false at the end.
  bool grab() {
    if (grabbed_) return true;
    if (at_end_) return false;
    const std::int64_t index = next_.index + 1;
    if (!video_.grab()) {
      // The container's count is an estimate; but many frames less are frames that got lost.
      ends_early_ = info_.frame_count && index + 2 + *info_.frame_count / 50 < *info_.frame_count;
      at_end_ = !ends_early_;
      if (at_end_) return false;
    }
    next_.t_capture_ns = time_of(index);
    next_.index = index;
    next_.name = "frame " + std::to_string(index);
    grabbed_ = true;
    return true;
  }

  /// The container's time; where that is none, or does not increase, the frame before and the rate give it (counted).
  std::int64_t time_of(std::int64_t index) {
    if (!info_.has_times) return index;
    const std::int64_t by_rate = index == 0 ? 0 : next_.t_capture_ns + std::llround(1e9 / info_.rate_hz);
    if (ends_early_) return by_rate;  // there is no frame, and so no time to be wrong
    const double t_ns = video_.get(cv::CAP_PROP_POS_MSEC) * 1e6;
    const bool plausible = std::isfinite(t_ns) && std::abs(t_ns) < 9e18;
    if (plausible && (index == 0 || std::llround(t_ns) > next_.t_capture_ns)) return std::llround(t_ns);
    ++times_replaced_;
    return by_rate;
  }

  void retrieve(EncodedImage& image) {
    image.encoding = Encoding::bgr24;
    image.width = width_;
    image.height = height_;
    image.stride = std::ptrdiff_t{3} * width_;
    image.bytes.resize(static_cast<std::size_t>(image.stride) * static_cast<std::size_t>(height_));
    cv::Mat target(height_, width_, CV_8UC3, image.bytes.data());
    if (!video_.retrieve(target) || target.empty() || target.type() != CV_8UC3) {
      throw FrameError(info_.path + ", " + next_.name + ": cannot be decoded to 8-bit colour");
    }
    if (target.data == image.bytes.data()) return;
    // Another size than the container said: OpenCV took memory of its own.
    image.width = width_ = target.cols;
    image.height = height_ = target.rows;
    image.stride = std::ptrdiff_t{3} * target.cols;
    image.bytes.resize(static_cast<std::size_t>(image.stride) * static_cast<std::size_t>(target.rows));
    target.copyTo(cv::Mat(target.rows, target.cols, CV_8UC3, image.bytes.data()));
  }

  cv::VideoCapture video_;
  SequenceInfo info_;
  int width_, height_;  ///< of the last frame; of the container before the first
  FrameStamp next_{-1, 0, {}};
  bool grabbed_ = false;
  bool ends_early_ = false;
  bool at_end_ = false;
  std::atomic<std::int64_t> times_replaced_{0};
};

void take_video_calibration(SequenceInfo& info, const SequenceOptions& options, int width, int height) {
  std::string file = options.calibration;
  const fs::path beside_yaml = fs::path(info.path).replace_extension(".yaml");
  const fs::path beside_yml = fs::path(info.path).replace_extension(".yml");
  if (file.empty() && is_file(beside_yaml)) file = beside_yaml.string();
  if (file.empty() && is_file(beside_yml)) file = beside_yml.string();
  if (file.empty()) {
    info.calibration_source = "none: neither " + beside_yaml.string() + " nor .yml: give one with --calibration FILE";
    return;
  }
  Calibration calibration = read_calibration(file, {{}, width, height});
  match_image_size(calibration, width, height, info.path);
  info.camera = calibration.camera;
  info.calibration_source = calibration.source;
}

/// A line per frame. By time it cannot go: the frames' times are known only as they come.
void take_video_groundtruth(SequenceInfo& info, const std::string& option) {
  info.groundtruth_source = option == "none" ? "none (--groundtruth none)" : "none: a video has none of its own";
  if (option.empty() || option == "none") return;
  const Trajectory poses = read_trajectory(option);
  if (!poses.t_ns.empty()) {
    fail_at(option, 0,
            "goes by time, which a video's frames tell only when they come: give poses in KITTI's format, a line per "
            "frame");
  }
  Recording recording;
  recording.frames.resize(poses.T_w_c.size());
  set_groundtruth_by_line(recording, poses, option);
  info.groundtruth = std::move(recording.info.groundtruth);
  info.groundtruth_frames = std::move(recording.info.groundtruth_frames);
  info.groundtruth_source = option;
}

}  // namespace

std::unique_ptr<Sequence> open_video(const std::string& source, const SequenceOptions& options) {
  const std::string expected = "expected a video that OpenCV reads (FFmpeg), or a directory with a recorded sequence";
  cv::VideoCapture video;
  try {
    video.open(source, cv::CAP_FFMPEG);
  } catch (const cv::Exception&) {
    fail_at(source, 0, "is no video: " + expected);
  }
  const int width = static_cast<int>(video.get(cv::CAP_PROP_FRAME_WIDTH)),
            height = static_cast<int>(video.get(cv::CAP_PROP_FRAME_HEIGHT));
  if (!video.isOpened() || width <= 0 || height <= 0) fail_at(source, 0, "is no video: " + expected);
  SequenceInfo info;
  info.layout = "video";
  info.path = source;
  const double count = video.get(cv::CAP_PROP_FRAME_COUNT), fps = video.get(cv::CAP_PROP_FPS);
  if (count >= 1 && count < 1e9) info.frame_count = static_cast<std::int64_t>(count);
  info.rate_hz = fps > 0 && fps <= kHighestRate_hz ? fps : options.rate_hz;
  info.has_times = info.rate_hz > 0;
  take_video_calibration(info, options, width, height);
  take_video_groundtruth(info, options.groundtruth);
  return std::make_unique<VideoSequence>(video, std::move(info), width, height);
}

}  // namespace pavo
