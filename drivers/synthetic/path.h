// The street's centre line, and how the camera drives along it.
//
// Frame "street": x and z horizontal, y down, the road at y = -height(s); right-handed as a camera's. Along the centre
// line a place is (s, l): s metres along, l metres to the right.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "drivers/synthetic/options.h"
#include "types/pose.h"

namespace pavo::synthetic {

/// A piece of the centre line: straight, or a circle's arc (curvature > 0 turns right), tangent to its neighbours.
struct PathPiece {
  double s = 0, length = 0, curvature = 0;
  double x = 0, z = 0, heading = 0;  ///< where it starts; heading 0 looks along +z, rising to the right
};

struct PathPoint {
  double x = 0, z = 0, heading = 0;
};

class Path {
 public:
  /// An open path for a drive of `distance` metres, with a run-up before s = 0 and a prospect behind its end; or a
  /// loop.
  Path(std::uint32_t seed, double distance, bool loop, double hills_m = 0);

  double begin() const { return pieces_.front().s; }
  double end() const { return pieces_.back().s + pieces_.back().length; }
  bool loop() const { return loop_; }
  const std::vector<PathPiece>& pieces() const { return pieces_; }
  /// Curvature at s; a loop takes any s, an open path goes straight on beyond its ends.
  double curvature(double s) const;
  PathPoint at(double s, double l) const;
  /// Of the road over where it is at s = 0, and how it rises there per metre. Level across the street.
  double height(double s) const;
  double slope(double s) const;
  double steepest() const;  ///< slope anywhere
  bool is_level() const { return hills_m_ == 0; }
  /// s, on a loop brought into [begin, end).
  double wrap(double s) const;

 private:
  const PathPiece& piece(double& s) const;
  void add(double length, double turn_rad);
  void add_leg(double length, float bend_rad);

  std::vector<PathPiece> pieces_;
  bool loop_ = false;
  double hills_m_ = 0;
};

/// The camera's way: distance driven and pose of every frame.
class Drive {
 public:
  Drive(const SyntheticOptions& options, std::uint32_t seed);

  static double length(const SyntheticOptions& options);

  const Path& path() const { return path_; }
  int frames() const { return static_cast<int>(s_.size()); }
  double s(int frame) const { return s_[static_cast<std::size_t>(frame)]; }
  int first_at(double s) const;    ///< the first frame that is at s or beyond
  double lateral(double s) const;  ///< l of the camera: in the right lane, with some wander
  SE3 T_street_camera(int frame) const;
  double time(int frame) const { return frame / rate_hz_; }

 private:
  Path path_;
  std::vector<double> s_;
  double rate_hz_, height_m_, pitch_rad_;
  double phase_[6];
};

}  // namespace pavo::synthetic
