// The ground plane from two images: where the road lies so that both see the same on it.
//
// Blocks of the current image, on what geometry says is road, are compared with the reference image through the
// homography of the plane,  X_ref = R X_cur + t,  n.X_cur = d  =>  x_ref ~ (R + t m^T) x_cur,  m = n / d.
// Each block tells along its epipolar direction how far its inverse depth is off (Lucas and Kanade, by inverse
// composition: Baker and Matthews, IJCV 2004); a robust weighted fit over all blocks moves m, which is linear in them.
// Cars, people, kerbs and shadows are blocks that disagree. What is not known exactly of the motion, the rotation and
// the direction of t, is estimated along under its own prior, so that its uncertainty is in m's.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "stages/ground/ground_image.h"
#include "stages/ground/ground_plane.h"
#include "stages/ground/scale_votes.h"
#include "stages/people/people.h"
#include "types/camera.h"
#include "types/pose.h"

namespace pavo {

struct AlignGroundOptions {
  double nearest_slope = 0.6;    ///< tangent below the horizon of the nearest ground that is looked at
  double farthest_slope = 0.09;  ///< and of the farthest: height over distance
  double half_width = 3;         ///< of the strip of ground beside the direction of travel, in heights of the camera
  double roughness = 0.015;      ///< of the ground: deviation of its height from the plane, in heights of the camera
  double lane = 1.2;             ///< farther aside, in heights of the camera, the ground grows rougher, by the square
  double rotation_sigma_rad = 2e-4;  ///< of the given R
  double direction_sigma = 2e-3;     ///< of the given direction of t, radians
  double curvature = 5e-4;           ///< of the road along the way, times the camera's height: its sigma
  double least_texture = 400;        ///< variance of a block's gray values, times 256: less tells nothing
  std::size_t most_blocks = 64;
  int min_blocks = 8;          ///< that agree
  int min_agreed = 3;          ///< textured blocks that look like ground, at least
  double min_agreement = 0.2;  ///< share of the textured blocks that has to look like ground
  double max_tilt = 0.12;      ///< radians, from the attitude that was believed: more is no ground
  double max_sigma = 0.15;     ///< of ln |m|: a worse measurement is none
};

/// What is believed of m before the images are looked at.
struct GroundPrior {
  Eigen::Vector3d m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< inverse covariance of m
};

enum class GroundReason : std::uint8_t {
  seen,
  no_motion,       ///< too short a way between the frames
  too_few_blocks,  ///< nothing of the ground is in both images, or people stand on it
  no_texture,      ///< the blocks do not tell how far away they are
  no_agreement,    ///< they lie on no common plane near the one that was expected
};

struct GroundMeasurement {
  bool found = false;
  GroundReason reason = GroundReason::too_few_blocks;
  /// m = n / d of the current camera, per unit of T_ref_cur's translation: |m| = 1 / (height in that unit).
  Eigen::Vector3d m = Eigen::Vector3d::Zero();
  /// Of m, inverse covariance: what the images say, the motion's uncertainty included, the prior not.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  /// m is where images and prior together are most likely; the images alone pull on it so: information * (their m - m).
  Eigen::Vector3d pull = Eigen::Vector3d::Zero();
  double slope = 0;  ///< of the rays to the ground that was seen, on average: height over distance
  int blocks = 0;    ///< that were compared
  int asked = 0;     ///< of these, with texture enough to look different if the plane is wrong
  int agreed = 0;    ///< of these, that do not
  double sigma = 0;  ///< standard deviation of ln |m|
};

/// One caller at a time (it owns its working memory). Allocates where an image is larger than ever before; never
/// blocks. The same input gives the same output.
class AlignGround {
 public:
  AlignGround(const Camera& rectified, const AlignGroundOptions& options) : camera_(rectified), options_(options) {}

  /// `T_ref_cur` maps points of the current camera into the reference camera, in any unit. `people` are those of the
  /// current image.
  GroundMeasurement operator()(const GroundImage& current, const GroundImage& reference, const SE3& T_ref_cur,
                               const GroundPrior& prior, const People& people);

  /// For a start that knows little: adds to `votes`, for every length of the way, what share of the texture in the
  /// strip of ground it explains, at the pitch (near the given one) that explains most.
  void vote(const GroundImage& current, const GroundImage& reference, const SE3& T_ref_cur,
            const GroundAttitude& attitude, double pitch_sigma, double height_m, const People& people,
            ScaleVotes& votes);

  const AlignGroundOptions& options() const { return options_; }

  struct Block {
    int x = 0, y = 0;              // top left pixel, in its level
    Eigen::Vector3d ray;           // through its centre
    double aside = 0;              // of the way, in heights of the camera
    float xx = 0, xy = 0, yy = 0;  // sums of products of the gradients, less their means
    int pixels = 0;
    float variance = 0;  // sum of squared gray values, less their mean
    // of the last comparison:
    bool seen = false;
    float at_rest = 0;  // as squared, of the same pixels in both images
    float bx = 0, by = 0, squared = 0;
    float looks = 0;  // like ground: 0..1
    double information = 0, shift = 0, fits = 0;
    Eigen::Matrix<double, 6, 1> nuisance = Eigen::Matrix<double, 6, 1>::Zero();
  };
  const std::vector<Block>& blocks() const { return blocks_; }  ///< of the last call, to be looked at

 private:
  static constexpr int kNuisances = 6;  // rotation x y z; two directions of t; the road's curvature
  static constexpr int kUnknowns = 3 + kNuisances;
  using VectorN = Eigen::Matrix<double, kUnknowns, 1>;
  using MatrixN = Eigen::Matrix<double, kUnknowns, kUnknowns>;
  struct Fit {
    Eigen::Vector3d m;
    SE3 T_ref_cur;
    Eigen::Matrix<double, 3, 2> sideways;          // directions in which t may be wrong, times its length
    VectorN motion_information = VectorN::Zero();  // prior of the motion's errors and the curvature; 0 for m
    VectorN moved = VectorN::Zero();               // since the start
    VectorN step = VectorN::Zero();                // the last one
    MatrixN normal = MatrixN::Zero();
  };

  void choose_blocks(const GroundImage& current, const GroundImage& reference, int level, const Eigen::Vector3d& m,
                     const SE3& T_ref_cur, const People& people);
  void compare_all(const GroundImage& current, const GroundImage& reference, int level, const SE3& T,
                   const Eigen::Vector3d& m);
  void compare(const GroundImage& current, const GroundImage& reference, int level, const SE3& T,
               const Eigen::Vector3d& m);
  void take_telling_blocks(const GroundImage& current, const GroundImage& reference, int level, const SE3& T_ref_cur);
  static void compare_at_rest(const GroundImage& current, const GroundImage& reference, int level,
                              const Eigen::Matrix3d& H_infinity, Block& block);
  double noise();
  void descend(const GroundImage& current, const GroundImage& reference, int level, const SE3& T_ref_cur);
  void judge_looks(bool coarse);
  void solve(const GroundPrior& prior, double tolerance, Fit& fit);
  void refine(const GroundImage& current, const GroundImage& reference, int level, const GroundPrior& prior,
              int iterations, Fit& fit);
  void count(GroundMeasurement& result) const;
  void conclude(const GroundPrior& prior, const Fit& fit, GroundMeasurement& result) const;

  Camera camera_;
  AlignGroundOptions options_;
  std::vector<Block> blocks_, coarse_;
  std::vector<float> noises_;
};

}  // namespace pavo
