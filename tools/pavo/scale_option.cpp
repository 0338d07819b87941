#include "tools/pavo/scale_option.h"

#include <fmt/format.h>

#include <limits>

#include "drivers/trajectories/append_file.h"
#include "drivers/trajectories/speed_file.h"
#include "pavo/live_speed_step.h"
#include "tools/pavo/open_source.h"
#include "tools/pavo/usage_error.h"

namespace pavo {
namespace {

Scale from_live_speed(const std::string& where) {
  auto step = std::make_shared<LiveSpeedStep>(where);
  const auto counts = [step]() -> nlohmann::ordered_json {
    const SpeedCounts c = step->counts();
    return {{"samples", c.samples}, {"refused", c.refused}, {"first_refused", c.first_refused}};
  };
  return {step, "speed, live (" + where + ")", counts};
}

// Live, a pipe or a socket is listened to. In a replay, whose result must not depend on when a line comes, a pipe is
// read to its end first.
Scale from_speed(const std::string& file, bool live) {
  const bool socket = file.starts_with("unix:");
  if (live && (socket || file == "-")) return from_live_speed(file);
  if (socket)
    throw UsageError("--scale speed=" + file + ": a socket is for --live; a replay needs a file, or - (a pipe)");
  std::vector<SpeedStep::Sample> samples;
  const std::vector<SpeedSample> read =
      file == "-" ? parse_speed(read_whole_file("/dev/stdin"), "standard input") : read_speed(file);
  for (const SpeedSample& s : read) samples.push_back({s.t_ns, s.m_per_s});
  return {std::make_shared<SpeedStep>(std::move(samples)), "speed (" + file + ")"};
}

// The positions by frame; NaN where the truth does not reach.
std::shared_ptr<const StepLength> true_steps(const SequenceInfo& info) {
  std::vector<Eigen::Vector3d> positions;
  for (std::size_t i = 0; i < info.groundtruth_frames.size(); ++i) {
    const auto frame = static_cast<std::size_t>(info.groundtruth_frames[i]);
    positions.resize(frame, Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
    positions.push_back(info.groundtruth->T_w_c[i].t);
  }
  return std::make_shared<GroundtruthStep>(std::move(positions));
}

Scale from_groundtruth(const SequenceInfo& info, const std::string& source, Config config, const std::string& file) {
  if (!file.empty()) {  // the same sequence, seen with that truth
    config.source.groundtruth = file;
    const SequenceInfo other = open_source(source, config)->info();
    if (!other.groundtruth) throw std::runtime_error("--scale groundtruth=" + file + ": " + other.groundtruth_source);
    return {true_steps(other), "groundtruth (" + other.groundtruth_source + ")"};
  }
  if (!info.groundtruth && config.source.groundtruth == "none") {  // which is about the plot and the report
    config.source.groundtruth.clear();
    return from_groundtruth(open_source(source, config)->info(), source, config, file);
  }
  if (!info.groundtruth)
    throw std::runtime_error("--scale groundtruth: " + info.path +
                             " has no ground truth of its own; name a file: --scale groundtruth=FILE");
  return {true_steps(info), "groundtruth (" + info.groundtruth_source + ")"};
}

}  // namespace

Scale scale_of(const Config& config, const std::string& source, const SequenceInfo& info) {
  const std::string& text = config.odometry.scale;
  const std::size_t equals = text.find('=');
  const std::string kind = text.substr(0, equals);
  const std::string file = equals == std::string::npos ? "" : text.substr(equals + 1);
  if (kind == "unit" && equals == std::string::npos) return {std::make_shared<UnitStep>(), "unit"};
  if (scale_from_camera_height(config))
    return {std::make_shared<UnknownStep>(), fmt::format("camera height ({} m)", config.camera.height_m)};
  if (kind == "speed" && !file.empty()) return from_speed(file, config.source.mode == "live");
  if (kind == "groundtruth") return from_groundtruth(info, source, config, file);
  throw UsageError(
      "--scale (odometry.scale) must be unit, camera-height[=M], speed=FILE|-|unix:PATH or groundtruth[=FILE], not '" +
      text + "'");
}

}  // namespace pavo
