#include "pavo/visual_odometry.h"

#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "engine/clock.h"
#include "pavo/odometry_pipeline.h"

namespace pavo {
namespace {

Config config_of(const VisualOdometryOptions& options) {
  Config config;
  if (!options.config_file.empty()) read_config(options.config_file, config);
  if (options.live) config.source.mode = "live";
  if (config.odometry.scale != "unit" && !scale_from_camera_height(config))
    throw std::runtime_error(
        "odometry.scale must be unit or camera-height=M here: a library's frames come without ground truth or speed");
  settle_camera_height(config);
  return config;
}

std::shared_ptr<const StepLength> step_length_of(const Config& config) {
  if (scale_from_camera_height(config)) return std::make_shared<UnknownStep>();
  return std::make_shared<UnitStep>();
}

PoseEstimate estimate_of(const Frame& frame, const FrameInfo& info, const Outcome& outcome) {
  PoseEstimate estimate;
  estimate.frame = info.source_index;
  estimate.t_capture_ns = info.t_capture_ns;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      estimate.T_world_camera[4 * row + column] = frame.pose.T_w_c.R(row, column);
    estimate.T_world_camera[4 * row + 3] = frame.pose.T_w_c.t(row);
  }
  estimate.quality = name_of(frame.pose.quality);
  if (outcome.failed) estimate.failure = std::string(outcome.stage) + ": " + std::string(outcome.message);
  estimate.matches = frame.pose.matches;
  estimate.inliers = frame.pose.inliers;
  estimate.people = static_cast<int>(frame.people.size());
  return estimate;
}

}  // namespace

struct VisualOdometry::Impl {
  Impl(const Camera& image_camera, const VisualOdometryOptions& options) : Impl(image_camera, config_of(options)) {}
  Impl(const Camera& image_camera, const Config& config)
      : camera(image_camera), odometry(config, camera, step_length_of(config), Input::gray, clock) {}

  SteadyClock clock;
  Camera camera;
  OdometryPipeline odometry;
  std::int64_t pushed = 0;
  bool finished = false;
};

VisualOdometry::VisualOdometry(const Camera& camera, const VisualOdometryOptions& options, OnPose on_pose)
    : impl_(std::make_unique<Impl>(camera, options)) {
  if (!on_pose) throw std::invalid_argument("VisualOdometry: no on_pose: expected a function that takes the poses");
  impl_->odometry.engine().deliver(
      [on_pose = std::move(on_pose)](const Frame& frame, const FrameInfo& info, const Outcome& outcome) {
        on_pose(estimate_of(frame, info, outcome));
      });
  impl_->odometry.engine().start();
}

VisualOdometry::~VisualOdometry() = default;

bool VisualOdometry::push(const std::uint8_t* gray, std::ptrdiff_t stride, std::int64_t t_capture_ns) {
  if (impl_->finished) throw std::logic_error("VisualOdometry: push() behind finish()");
  if (!gray) throw std::invalid_argument("VisualOdometry: push() of no pixels: expected a pointer to the first row");
  if (std::abs(stride) < impl_->camera.width)
    throw std::invalid_argument("VisualOdometry: push() with rows " + std::to_string(stride) +
                                " bytes apart: expected at least the camera's width, " +
                                std::to_string(impl_->camera.width));
  const std::int64_t number = impl_->pushed++;
  return impl_->odometry.engine().admit([&](FrameInfo& info, Frame& frame) {
    info.source_index = number;
    info.t_capture_ns = t_capture_ns;
    Image& image = impl_->odometry.gray_input(frame);
    image.resize(impl_->camera.width, impl_->camera.height);
    for (int y = 0; y < image.height(); ++y)
      std::memcpy(image.row(y), gray + y * stride, static_cast<std::size_t>(image.width()));
  });
}

void VisualOdometry::finish() {
  if (impl_->finished) return;
  impl_->finished = true;
  impl_->odometry.engine().finish();
}

}  // namespace pavo
