#include "drivers/synthetic/synthetic_street.h"

#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <stdexcept>
#include <string>

#include "drivers/synthetic/renderer.h"

namespace pavo {

struct SyntheticStreet::Impl {
  Impl(const SyntheticOptions& o, const Camera& camera) : options(o), renderer(o, camera) {}

  FrameStamp stamp() const {
    FrameStamp s;
    s.index = next;
    s.t_capture_ns = std::llround(1e9 / options.rate_hz * next);
    char name[32];
    std::snprintf(name, sizeof name, "%06d.png", next);
    s.name = name;
    return s;
  }

  SyntheticOptions options;
  synthetic::Renderer renderer;
  SequenceInfo info;
  SE3 T_street_first;
  int next = 0;
};

SyntheticStreet::SyntheticStreet(const SyntheticOptions& options) {
  const Camera camera = synthetic_camera(options);
  impl_ = std::make_unique<Impl>(options, camera);
  SequenceInfo& info = impl_->info;
  info.layout = "synthetic";
  info.path = "synthetic";
  info.camera = camera;
  info.calibration_source = "synthetic";
  info.groundtruth_source = "synthetic";
  info.has_times = true;
  info.rate_hz = options.rate_hz;
  info.frame_count = options.frames;
  const synthetic::Drive& drive = impl_->renderer.world().drive;
  impl_->T_street_first = drive.T_street_camera(0);
  const SE3 T_first_street = impl_->T_street_first.inverse();
  Trajectory truth;
  for (int k = 0; k < options.frames; ++k) {
    truth.T_w_c.push_back(k == 0 ? SE3{} : T_first_street * drive.T_street_camera(k));
    truth.t_ns.push_back(std::llround(1e9 / options.rate_hz * k));
  }
  info.groundtruth_frames.resize(truth.T_w_c.size());
  std::iota(info.groundtruth_frames.begin(), info.groundtruth_frames.end(), std::int64_t{0});
  info.groundtruth = std::move(truth);
}

SyntheticStreet::~SyntheticStreet() = default;

const SequenceInfo& SyntheticStreet::info() const {
  return impl_->info;
}
const SyntheticOptions& SyntheticStreet::options() const {
  return impl_->options;
}

std::optional<FrameStamp> SyntheticStreet::peek() {
  if (impl_->next >= impl_->options.frames) return std::nullopt;
  return impl_->stamp();
}

bool SyntheticStreet::read(EncodedImage& image, FrameStamp& stamp) {
  if (impl_->next >= impl_->options.frames) return false;
  stamp = impl_->stamp();
  image.encoding = Encoding::gray8;
  image.width = impl_->options.width;
  image.height = impl_->options.height;
  image.stride = image.width;
  image.bytes.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  impl_->renderer.render(impl_->next, image.bytes.data());
  ++impl_->next;
  return true;
}

bool SyntheticStreet::skip() {
  if (impl_->next >= impl_->options.frames) return false;
  ++impl_->next;
  return true;
}

std::vector<SyntheticPerson> SyntheticStreet::people(int frame) const {
  if (frame < 0 || frame >= impl_->options.frames)
    throw std::out_of_range("synthetic street: frame " + std::to_string(frame) + " of " +
                            std::to_string(impl_->options.frames));
  return impl_->renderer.people(frame);
}

Eigen::Vector3d SyntheticStreet::road_normal() const {
  return impl_->T_street_first.R.transpose() * Eigen::Vector3d::UnitY();
}
double SyntheticStreet::road_height() const {
  return -impl_->T_street_first.t.y();
}

}  // namespace pavo
