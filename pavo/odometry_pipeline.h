// The stages on the engine: what `pavo run` and the library both run.
//
//   decode -> undistort -> features ----------------> odometry -> delivery
//                      \-> scan -> people ----------/   ^ \-> map (estimator "keyframe"; in the background)
//                                                       |------/ some frames later
//
// Stages that a source does not need are not in the graph: uncompressed frames are not decoded, rectified ones not
// undistorted, and without people removal nobody looks for people.
#pragma once

#include <functional>
#include <memory>

#include "engine/pipeline.h"
#include "pavo/config.h"
#include "pavo/frame.h"
#include "stages/pose/scale.h"
#include "types/camera.h"

namespace pavo {

enum class Input {
  encoded,  ///< the source fills Frame::encoded
  gray,     ///< the source fills Frame::raw, or Frame::image where the camera is rectified: gray_input() knows
};

class OdometryPipeline {
 public:
  /// `camera`: of the source's images. Turns OpenCV's own threads off, for the whole process: its loops would take the
  /// cores from the workers. Throws std::runtime_error and std::invalid_argument on settings that do not go together.
  OdometryPipeline(const Config& config, const Camera& camera, std::shared_ptr<const StepLength> step_length,
                   Input input, Clock& clock);
  ~OdometryPipeline();

  Pipeline<Frame>& engine() { return *pipeline_; }
  const Camera& rectified_camera() const { return rectified_; }
  /// The image of a frame that a source of gray images fills in.
  Image& gray_input(Frame& frame) const { return undistorted_ ? frame.raw : frame.image; }

 private:
  void add_scan(const Config& config);
  void add_frame_to_frame(const Config& config, std::shared_ptr<const StepLength> step_length);
  void add_keyframe(const Config& config, std::shared_ptr<const StepLength> step_length);

  struct Stages;
  Camera rectified_;
  bool undistorted_ = false;
  std::unique_ptr<Stages> stages_;
  std::unique_ptr<Pipeline<Frame>> pipeline_;  // last: it refers to the stages
};

}  // namespace pavo
