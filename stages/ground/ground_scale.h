// Metres from the camera's height: looks at the ground between pairs of frames, fused by a filter.
//
// An estimator with a map calls observe() once per frame, with the pose in the map's own unit: metres_per_unit() is
// then what its steps are to be multiplied with, and cannot drift. One whose steps have no common unit calls step().
#pragma once

#include <array>
#include <cstdint>

#include "stages/ground/align_ground.h"
#include "stages/ground/ground_image.h"
#include "stages/ground/scale_filter.h"
#include "stages/people/people.h"
#include "types/camera.h"
#include "types/image.h"
#include "types/pose.h"

namespace pavo {

struct GroundScaleOptions {
  AlignGroundOptions align;
  ScaleFilterOptions filter;
  double baseline = 1.0;      ///< wanted between the frames of a look, in heights of the camera
  double scale_walk = 2e-3;   ///< of ln(metres per unit) of a map, from look to look
  double acceleration = 2.5;  ///< m/s^2, by which a step() may differ from the one before
  double start_sigma = 0.1;   ///< of ln(metres per unit), what the very first look is trusted to
};

/// What one frame said.
struct GroundLook {
  GroundMeasurement measurement;      ///< of the current frame, per unit of the map (step(): of the step)
  bool used = false;                  ///< it went into the filter
  std::int64_t reference_frame = -1;  ///< what the frame was compared with; -1: nothing
};

/// One caller at a time, frames in order; never blocks. Allocates only for a larger image than ever before. The same
/// input gives the same output. It keeps what it needs of the last frames' images itself.
class GroundScale {
 public:
  /// `rectified`: the camera of the images. Throws std::invalid_argument where the height is not positive.
  GroundScale(const Camera& rectified, const GroundScaleOptions& options);

  /// A frame whose pose in the map is known (any unit, the same for all frames since restart()). Compares it with an
  /// earlier one that is about `baseline` away. `people`: of this frame.
  GroundLook observe(std::int64_t frame, const ImageView& image, const SE3& T_map_camera, const People& people);

  /// Keeps a frame for step(). observe() does so by itself.
  void remember(std::int64_t frame, const ImageView& image);
  /// Two frames that are remembered, and the motion between them, whose length is not known. `expected_m`: by the
  /// motion model, 0 where there is none; `seconds` between them. Afterwards metres_per_unit() times |t| is the step's
  /// length.
  GroundLook step(std::int64_t frame, std::int64_t reference_frame, const SE3& T_reference_current, double expected_m,
                  double seconds, const People& people);

  /// The map was scaled about a point of it: new coordinates = fixed + factor * (old ones - fixed).
  void rescale(double factor, const Eigen::Vector3d& fixed);
  /// A new map, in a unit that has nothing to do with the old one's. How the camera is held stays known.
  void restart();

  bool known() const { return filter_.known(); }  ///< false until the ground was seen: scale is a guess then
  double metres_per_unit() const { return filter_.metres_per_unit(); }
  /// Of (ln metres per unit, pitch, roll).
  const Eigen::Matrix3d& covariance() const { return filter_.covariance(); }
  double sigma() const { return filter_.sigma(); }  ///< standard deviation of its logarithm
  /// Camera to ground, refined. What finds people by the ground can use it.
  GroundAttitude attitude() const { return filter_.attitude(); }
  /// For other measurements of metres per unit (wheels, people).
  ScaleFilter& filter() { return filter_; }
  const AlignGround& align() const { return align_; }

 private:
  struct Remembered {
    std::int64_t frame = -1;
    SE3 T_map_camera;
    bool posed = false;
    GroundImage image;
  };
  static constexpr std::size_t kRemembered = 8;

  Remembered& newest(std::int64_t frame, const ImageView& image);
  const Remembered* choose_reference(const SE3& T_map_camera) const;
  const Remembered* find(std::int64_t frame) const;
  void vote_with_others(const Remembered& current, const People& people);
  bool vote(const Remembered& current, const Remembered& reference, const SE3& T_ref_cur, const People& people);
  bool far_enough(const SE3& T_ref_cur) const;
  bool trusted(const GroundMeasurement& m) const;
  GroundMeasurement best_of_starts(const Remembered& current, const Remembered& reference, const SE3& T_ref_cur,
                                   const People& people);
  GroundLook look(const Remembered& current, const Remembered& reference, const SE3& T_ref_cur, const People& people);

  GroundScaleOptions options_;
  int top_;  // first row that can show ground
  AlignGround align_;
  ScaleVotes votes_;
  ScaleFilter filter_;
  std::array<Remembered, kRemembered> ring_;
  std::size_t next_ = 0;
  int unused_ = 0;  // looks in a row
};

}  // namespace pavo
