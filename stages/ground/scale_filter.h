// How many metres a unit of the map is, and how the camera is held over the ground: what single looks at the ground
// say, fused over time.
//
// State x = (ln metres per unit, pitch, roll), a random walk. A measured plane m (in units of the map) is seen as
//     z = (ln(h |m|), pitch of m, roll of m) + noise,
// the camera being h metres above the ground, on the whole. A look that does not fit what is known is left out; many of
// them in a row mean that what is known is wrong.
#pragma once

#include <Eigen/Core>

#include "stages/ground/align_ground.h"
#include "stages/ground/ground_plane.h"

namespace pavo {

struct ScaleFilterOptions {
  double height_m = 0;           ///< of the camera above the ground; has to be positive
  GroundAttitude attitude;       ///< how it is mounted, as far as known
  double attitude_sigma = 0.03;  ///< of that, radians
  double attitude_walk = 4e-4;   ///< of the mounting, radians a look
  double slope_sigma = 8e-3;     ///< of the car's springs and the road, radians, beside what the look itself says
  double travel_sigma = 4e-3;    ///< of the angle between the ground and the way over it: springs, humps
  double lever = 0.8;  ///< how far from the camera the ground begins to tilt, in distances of the ground that is seen
  double height_sigma = 0.01;  ///< of the height over the road at one place: its logarithm
  double repetition = 3;       ///< consecutive looks see the same ground: so many count as one
  double gate = 16;            ///< largest squared Mahalanobis distance (3 degrees of freedom)
  int misses_until_lost = 12;  ///< in a row
  int ways_until_strange = 2;  ///< ways in a row that do not fit: one may be a hump, so many are a wrong motion
  int ways_until_doubt = 6;    ///< ways in a row that do not fit: the attitude (and the scale, which came of it) is
  double doubt = 4;            ///< so many times less sure than was thought
};

/// One caller at a time; allocates nothing.
class ScaleFilter {
 public:
  /// Throws std::invalid_argument where the height is not positive and finite.
  explicit ScaleFilter(const ScaleFilterOptions& options);

  bool known() const { return known_; }  ///< false until the first look, and after restart()
  /// As of the last look (or other sensor): where none comes, it holds to the bit. Of no meaning unless known().
  double metres_per_unit() const;
  double sigma() const;  ///< standard deviation of its logarithm
  GroundAttitude attitude() const { return {x_(1), x_(2)}; }
  const Eigen::Matrix3d& covariance() const { return P_; }
  /// The last ways did not fit: the motion itself may be wrong, and so what it shows.
  bool ways_are_strange() const { return strange_ways_ >= options_.ways_until_strange; }
  double height_m() const { return options_.height_m; }

  /// Time passes: the logarithm of the scale walks by `scale_sigma`.
  void predict(double scale_sigma);
  /// The unit is another one: new = old / factor (a map that was scaled by `factor`).
  void rescale(double factor);
  /// The unit is another one, of about so many metres; how sure that is stays as it was.
  void retarget(double metres_per_unit);
  /// The unit is unknown again (a new map); how the camera is held stays known.
  void restart();
  /// The unit is believed to be so many metres (ln: sigma): what a constant speed says, or another sensor.
  void assume(double metres_per_unit, double sigma);

  /// A look at the ground. False where it was left out.
  bool update(const GroundMeasurement& look);
  /// The camera moved that way (length 1, in its own frame). What it says of the mounting is what earlier looks meant
  /// for the scale, too; that is told with the next look. False where it was left out.
  bool travelled(const Eigen::Vector3d& direction);
  /// Another measurement of metres per unit: a wheel's speed, a person's height. False where it was left out.
  bool update(double metres_per_unit, double sigma);

  /// What a look is expected to say, for AlignGround: the attitude as it is known, the scale's logarithm not better
  /// than `least_sigma`.
  GroundPrior expected(double least_sigma = 0.1) const;

 private:
  ScaleFilterOptions options_;
  bool known_ = false;
  int misses_ = 0, strange_ways_ = 0;  // in a row
  double told_ = 0;                    // ln metres per unit, as of the last look
  Eigen::Vector3d x_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d P_ = Eigen::Matrix3d::Zero();
};

}  // namespace pavo
