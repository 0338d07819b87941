#include "stages/ground/align_ground.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "stages/ground/ground_block.h"

namespace pavo {
namespace {

// Two directions across t.
Eigen::Matrix<double, 3, 2> across(const Eigen::Vector3d& t) {
  const Eigen::Vector3d a =
      t.cross(std::abs(t.y()) < 0.9 * t.norm() ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX()).normalized();
  Eigen::Matrix<double, 3, 2> B;
  B << a * t.norm(), t.normalized().cross(a) * t.norm();
  return B;
}

bool on_people(const People& people, double x0, double y0, double x1, double y1) {
  for (const PersonBox& p : people)
    if (x1 >= p.x && x0 <= p.x + p.width && y1 >= p.y && y0 <= p.y + 1.05 * p.height) return true;
  return false;
}

Eigen::Matrix3d homography(const Camera& c, const Camera& r, const SE3& T, const Eigen::Vector3d& m) {
  Eigen::Matrix3d K_inverse, K;
  K_inverse << 1 / c.fx, 0, -c.cx / c.fx, 0, 1 / c.fy, -c.cy / c.fy, 0, 0, 1;
  K << r.fx, 0, r.cx, 0, r.fy, r.cy, 0, 0, 1;
  return K * (T.R + T.t * m.transpose()) * K_inverse;
}

Eigen::Matrix3d homography_at_infinity(const Camera& camera, const GroundImage& current, const GroundImage& reference,
                                       int level, const SE3& T) {
  return homography(camera_of_level(camera, current.top(), level), camera_of_level(camera, reference.top(), level), T,
                    Eigen::Vector3d::Zero());
}

}  // namespace

// The strip of ground to look at lies along the way. Blocks next to it come first; more of them are taken only where
// people or emptiness leave too few.
void AlignGround::choose_blocks(const GroundImage& current, const GroundImage& reference, int level,
                                const Eigen::Vector3d& m, const SE3& T_ref_cur, const People& people) {
  blocks_.clear();
  const Camera c = camera_of_level(camera_, current.top(), level);
  const GroundImage::Level& image = current.level(level);
  const BlockSize size = block_size(level);
  const Eigen::Vector3d n = m.normalized();
  Eigen::Vector3d ahead = T_ref_cur.R.transpose() * T_ref_cur.t;
  if (ahead.z() < 0) ahead = -ahead;
  ahead = (ahead - n * n.dot(ahead)).normalized();
  const Eigen::Vector3d right = n.cross(ahead);
  const double zoom = 1 << level;
  for (int y = 1; y + size.height + 1 < image.height; y += size.height)
    for (int x = 1; x + size.width + 1 < image.width; x += size.width) {
      Block b;
      b.x = x, b.y = y;
      b.ray << (x + 0.5 * (size.width - 1) - c.cx) / c.fx, (y + 0.5 * (size.height - 1) - c.cy) / c.fy, 1;
      const double slope = n.dot(b.ray);
      if (slope < options_.farthest_slope || slope > options_.nearest_slope) continue;
      b.aside = std::abs(right.dot(b.ray)) / slope;
      if (b.aside > options_.half_width) continue;
      if (on_people(people, x * zoom, y * zoom + current.top(), (x + size.width) * zoom,
                    (y + size.height) * zoom + current.top()))
        continue;
      blocks_.push_back(b);
    }
  std::sort(blocks_.begin(), blocks_.end(),
            [](const Block& a, const Block& b) { return std::tie(a.aside, a.y, a.x) < std::tie(b.aside, b.y, b.x); });
  take_telling_blocks(current, reference, level, T_ref_cur);
}

// Those that would look different if they lay elsewhere.
void AlignGround::take_telling_blocks(const GroundImage& current, const GroundImage& reference, int level,
                                      const SE3& T_ref_cur) {
  const Eigen::Matrix3d H_infinity = homography_at_infinity(camera_, current, reference, level, T_ref_cur);
  const BlockSize size = block_size(level);
  std::size_t taken = 0;
  for (std::size_t i = 0; i < blocks_.size() && taken < options_.most_blocks; ++i) {
    Block b = blocks_[i];
    measure_texture(current.level(level), size, b);
    const double texture = b.variance / static_cast<float>(b.pixels);
    if (texture < options_.least_texture) continue;
    compare_at_rest(current, reference, level, H_infinity, b);
    if (b.at_rest < 0.3 * texture && b.at_rest < 4 * options_.least_texture)
      continue;  // it moves along with the camera
    blocks_[taken++] = b;
  }
  blocks_.resize(taken);
}

// How different every block is, nothing more.
void AlignGround::compare_all(const GroundImage& current, const GroundImage& reference, int level, const SE3& T,
                              const Eigen::Vector3d& m) {
  const Eigen::Matrix3d H = homography(camera_of_level(camera_, current.top(), level),
                                       camera_of_level(camera_, reference.top(), level), T, m);
  for (Block& b : blocks_)
    b.seen = compare_block(current.level(level), reference.level(level), block_size(level), H, b);
}

void AlignGround::compare(const GroundImage& current, const GroundImage& reference, int level, const SE3& T,
                          const Eigen::Vector3d& m) {
  const Camera c = camera_of_level(camera_, current.top(), level);
  const Camera r = camera_of_level(camera_, reference.top(), level);
  const BlockSize size = block_size(level);
  const Eigen::Matrix3d H = homography(c, r, T, m);
  const Eigen::Matrix<double, 3, 2> sideways = across(T.t);
  for (Block& b : blocks_) {
    b.seen = compare_block(current.level(level), reference.level(level), size, H, b);
    if (!b.seen) continue;
    // Everything below at the block's centre, in pixels of the current image.
    const double rho = m.dot(b.ray);
    const Eigen::Vector3d far = T.R * b.ray, X = far + T.t * rho;
    if (X.z() < 1e-6) {
      b.seen = false;
      continue;
    }
    Eigen::Matrix<double, 2, 3> projection;
    projection << r.fx / X.z(), 0, -r.fx * X.x() / squared(X.z()), 0, r.fy / X.z(), -r.fy * X.y() / squared(X.z());
    Eigen::Matrix2d W;  // of the warp, by the pixel
    W.col(0) = projection * ((T.R + T.t * m.transpose()).col(0) / c.fx);
    W.col(1) = projection * ((T.R + T.t * m.transpose()).col(1) / c.fy);
    const Eigen::Matrix2d back = W.inverse();
    const Eigen::Vector2d e = back * projection * T.t;
    Eigen::Matrix2d S;
    S << b.xx, b.xy, b.xy, b.yy;
    const Eigen::Vector2d Se = S * e;
    b.information = e.dot(Se);
    if (!(b.information > 0)) {
      b.seen = false;
      continue;
    }
    b.shift = -(e.x() * b.bx + e.y() * b.by) / b.information;
    Eigen::Matrix<double, 3, 5> moves;
    moves << 0, far.z(), -far.y(), 0, 0, -far.z(), 0, far.x(), 0, 0, far.y(), -far.x(), 0, 0, 0;
    moves.rightCols<2>() = sideways * rho;
    b.nuisance.head<5>() = (Se.transpose() * back * projection * moves).transpose() / b.information;
    b.nuisance(5) = -0.5 * m.squaredNorm() / rho;
  }
}

// How a block looks where it moves along with the camera, or is far away.
void AlignGround::compare_at_rest(const GroundImage& current, const GroundImage& reference, int level,
                                  const Eigen::Matrix3d& H_infinity, Block& block) {
  block.at_rest = std::numeric_limits<float>::infinity();
  for (const Eigen::Matrix3d& H : {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), H_infinity})
    if (compare_block(current.level(level), reference.level(level), block_size(level), H, block))
      block.at_rest = std::min(block.at_rest, block.squared);
}

// Variance of a pixel's difference where blocks fit: the median of the better half.
double AlignGround::noise() {
  constexpr double kLeast = 64;  // of rounding
  noises_.clear();
  for (const Block& b : blocks_)
    if (b.seen) noises_.push_back(b.squared);
  if (noises_.empty()) return kLeast;
  const auto middle = noises_.begin() + static_cast<std::ptrdiff_t>(noises_.size() / 4);
  std::nth_element(noises_.begin(), middle, noises_.end());
  return std::max<double>(*middle, kLeast);
}

// The blocks of the next finer level are those on the ones that fit.
void AlignGround::descend(const GroundImage& current, const GroundImage& reference, int level, const SE3& T_ref_cur) {
  const Eigen::Matrix3d H_infinity = homography_at_infinity(camera_, current, reference, level, T_ref_cur);
  coarse_.clear();
  coarse_.swap(blocks_);
  const Camera c = camera_of_level(camera_, current.top(), level);
  const BlockSize size = block_size(level);
  for (const Block& parent : coarse_) {
    if (!(parent.fits > 0.2) || blocks_.size() + 2 > options_.most_blocks) continue;
    for (int half = 0; half < 2; ++half) {
      Block b;
      b.x = 2 * parent.x, b.y = 2 * parent.y + half * size.height;
      b.aside = parent.aside;
      b.ray << (b.x + 0.5 * (size.width - 1) - c.cx) / c.fx, (b.y + 0.5 * (size.height - 1) - c.cy) / c.fy, 1;
      measure_texture(current.level(level), size, b);
      compare_at_rest(current, reference, level, H_infinity, b);
      blocks_.push_back(b);
    }
  }
}

// One robust weighted least squares fit over all blocks, reweighted a few times: cheap beside comparing them.
void AlignGround::solve(const GroundPrior& prior, double tolerance, Fit& fit) {
  const double variance = noise();
  MatrixN prior_normal = fit.motion_information.asDiagonal();
  VectorN prior_right = -fit.motion_information.cwiseProduct(fit.moved);
  prior_normal.topLeftCorner<3, 3>() += prior.information;
  prior_right.head<3>() += prior.information * (prior.m - fit.m);
  fit.step.setZero();
  for (int round = 0; round < 4; ++round) {
    fit.normal = prior_normal;
    VectorN right = prior_right;
    for (Block& b : blocks_) {
      b.fits = 0;
      if (!b.seen) continue;
      VectorN J;
      J << b.ray, b.nuisance;
      const double roughness = options_.roughness * (1 + squared(b.aside / options_.lane));
      const double z_variance =
          std::max<double>(variance, b.squared) / b.information + squared(roughness * fit.m.dot(b.ray));
      const double z2 = squared(b.shift - J.dot(fit.step)) / z_variance;
      b.fits = squared(1 / (1 + z2 / squared(tolerance))) * b.looks;
      const double weight = b.fits / z_variance;
      fit.normal += weight * J * J.transpose();
      right += weight * b.shift * J;
    }
    fit.step = fit.normal.ldlt().solve(right);
  }
}

// A block looks like ground where the plane explains what it shows, and standing still does not.
void AlignGround::judge_looks(bool coarse) {
  const float strict = coarse ? 1.0f : 0.7f;
  for (Block& b : blocks_) {
    const float unlike = std::min(b.variance / static_cast<float>(b.pixels), b.at_rest);
    const float unexplained = b.squared / (unlike + 1.0f);
    b.looks = std::clamp((strict - unexplained) / 0.3f, coarse ? 0.1f : 0.0f, 1.0f);
  }
}

void AlignGround::refine(const GroundImage& current, const GroundImage& reference, int level, const GroundPrior& prior,
                         int iterations, Fit& fit) {
  for (int i = 0; i < iterations; ++i) {
    compare(current, reference, level, fit.T_ref_cur, fit.m);
    const bool coarse = level > 0 && i < 2;
    judge_looks(coarse);
    solve(prior, coarse ? 6 : 3, fit);
    if (!fit.step.allFinite()) return;
    fit.m += fit.step.head<3>();
    fit.moved += fit.step;
    fit.moved(8) = 0;  // the warp knows no curvature: each step says all of it
    const Eigen::Vector3d turn = fit.step.segment<3>(3);
    if (turn.norm() > 0)
      fit.T_ref_cur.R = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * fit.T_ref_cur.R;
    fit.T_ref_cur.t += fit.sideways * fit.step.segment<2>(6);
    if (fit.step.head<3>().norm() < 2e-4 * fit.m.norm()) return;
  }
}

// What share of the blocks that could have told otherwise look like ground.
void AlignGround::count(GroundMeasurement& result) const {
  int asked = 0, agreed = 0;
  for (const Block& b : blocks_) {
    if (!b.seen || b.at_rest < b.squared) continue;
    const float unlike = std::min(b.variance / static_cast<float>(b.pixels), b.at_rest);
    constexpr float kTexture = 1500;
    if (unlike < kTexture) continue;
    ++asked;
    agreed += b.squared < 0.5f * unlike;
  }
  result.asked = asked;
  result.agreed = agreed;
}

GroundMeasurement AlignGround::operator()(const GroundImage& current, const GroundImage& reference,
                                          const SE3& T_ref_cur, const GroundPrior& prior, const People& people) {
  GroundMeasurement result;
  result.m = prior.m;
  result.reason = GroundReason::no_motion;
  if (!(T_ref_cur.t.norm() > 0)) return result;
  Fit fit;
  fit.m = prior.m;
  fit.T_ref_cur = T_ref_cur;
  fit.sideways = across(T_ref_cur.t);
  fit.motion_information.segment<3>(3).setConstant(1 / squared(options_.rotation_sigma_rad));
  fit.motion_information.segment<2>(6).setConstant(1 / squared(options_.direction_sigma));
  fit.motion_information(8) = 1 / squared(options_.curvature);

  result.reason = GroundReason::too_few_blocks;
  choose_blocks(current, reference, 1, fit.m, T_ref_cur, people);
  result.blocks = static_cast<int>(blocks_.size());
  if (result.blocks < options_.min_blocks) return result;
  refine(current, reference, 1, prior, 5, fit);
  count(result);
  result.reason = GroundReason::no_agreement;
  if (!fit.step.allFinite() || result.agreed < options_.min_agreed ||
      result.agreed < options_.min_agreement * result.asked)
    return result;
  descend(current, reference, 0, fit.T_ref_cur);
  refine(current, reference, 0, prior, 4, fit);
  if (!fit.step.allFinite()) return result;
  conclude(prior, fit, result);
  return result;
}

// What the images say, without the prior of the plane; the motion's errors are marginalised.
void AlignGround::conclude(const GroundPrior& prior, const Fit& fit, GroundMeasurement& result) const {
  MatrixN normal = fit.normal;
  normal.topLeftCorner<3, 3>() -= prior.information;
  const Eigen::Matrix<double, 3, kNuisances> off = normal.topRightCorner<3, kNuisances>();
  result.information = normal.topLeftCorner<3, 3>() -
                       off * normal.bottomRightCorner<kNuisances, kNuisances>().inverse() * off.transpose();
  result.m = fit.m;
  result.pull = prior.information * (fit.m - prior.m);
  const double certainty = fit.m.dot(result.information * fit.m);  // of ln |m|, the attitude being known
  result.sigma = certainty > 0 ? 1 / std::sqrt(certainty) : std::numeric_limits<double>::infinity();
  double slopes = 0, fits = 0;
  for (const Block& b : blocks_) slopes += b.fits * fit.m.dot(b.ray), fits += b.fits;
  result.slope = fits > 0 ? slopes / (fits * fit.m.norm()) : options_.nearest_slope;
  // A wall or a car's tail is a plane too, but no ground.
  const bool level = fit.m.normalized().cross(prior.m.normalized()).norm() < options_.max_tilt;
  result.found = level && result.sigma < options_.max_sigma;
  result.reason = result.found ? GroundReason::seen : level ? GroundReason::no_texture : GroundReason::no_agreement;
}

}  // namespace pavo
