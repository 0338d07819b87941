#include "drivers/synthetic/path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/synthetic/random.h"

namespace pavo::synthetic {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRunUp = 40, kProspect = 180, kTurnRadius = 15, kLane = 1.4, kHills = 180;

}  // namespace

void Path::add(double length, double turn_rad) {
  PathPiece next{-kRunUp, length, turn_rad / length, 0, -kRunUp, 0};
  if (!pieces_.empty()) {
    next.s = end();
    const PathPoint p = at(next.s, 0);
    next.x = p.x;
    next.z = p.z;
    next.heading = p.heading;
  }
  pieces_.push_back(next);
}

/// Straight, a bend to one side, back, and the same mirrored: it ends on the line on which it began.
void Path::add_leg(double length, float bend_rad) {
  const double arc = 0.14 * length, straight = (length - 4 * arc) / 3;
  add(straight, 0);
  add(arc, bend_rad);
  add(arc, -bend_rad);
  add(straight, 0);
  add(arc, -bend_rad);
  add(arc, bend_rad);
  add(straight, 0);
}

Path::Path(std::uint32_t seed, double distance, bool loop, double hills_m) : hills_m_(hills_m) {
  Random random(hash(seed, 1));
  const double turn = kPi / 2 * kTurnRadius;
  if (loop) {
    // legs that face each other are equally long and equally bent: only then does the loop close
    const float bends[] = {random.uniform(0.06F, 0.11F), random.uniform(0.06F, 0.11F)};
    for (const int leg : {0, 1, 0, 1}) {
      add_leg(leg == 0 ? 110 : 65, bends[leg] * (random.chance(0.5F) ? 1.0F : -1.0F));
      add(turn, -kPi / 2);
    }
    loop_ = true;  // only now: before, its end was not its beginning
    return;
  }
  double side = random.chance(0.5F) ? 1 : -1;
  add(kRunUp, 0);
  for (double leg = 95; end() < distance + kProspect; leg = random.uniform(130, 170), side = -side) {
    add_leg(leg, random.uniform(0.06F, 0.11F) * (random.chance(0.5F) ? 1.0F : -1.0F));
    add(turn, side * kPi / 2);
  }
}

const PathPiece& Path::piece(double& s) const {
  s = wrap(s);
  const auto next =
      std::upper_bound(pieces_.begin() + 1, pieces_.end(), s, [](double a, const PathPiece& p) { return a < p.s; });
  return *(next - 1);
}

double Path::wrap(double s) const {
  if (!loop_) return s;
  const double round = end() - begin();
  return s - std::floor((s - begin()) / round) * round;
}

double Path::curvature(double s) const {
  return piece(s).curvature;
}

double Path::height(double s) const {
  return hills_m_ / 2 * (1 - std::cos(2 * kPi / kHills * s));
}

double Path::slope(double s) const {
  return hills_m_ * kPi / kHills * std::sin(2 * kPi / kHills * s);
}

double Path::steepest() const {
  return hills_m_ * kPi / kHills;
}

PathPoint Path::at(double s, double l) const {
  const PathPiece& p = piece(s);
  const double ds = s - p.s;
  double x = 0, z = ds, turn = 0;  // in the frame of the piece's start
  if (p.curvature != 0) {
    turn = ds * p.curvature;
    x = (1 - std::cos(turn)) / p.curvature;
    z = std::sin(turn) / p.curvature;
  }
  x += l * std::cos(turn);
  z -= l * std::sin(turn);
  const double c = std::cos(p.heading), n = std::sin(p.heading);
  return {p.x + c * x + n * z, p.z - n * x + c * z, p.heading + turn};
}

double Drive::length(const SyntheticOptions& options) {
  return options.frames * options.speed_mps / options.rate_hz;
}

Drive::Drive(const SyntheticOptions& options, std::uint32_t seed)
    : path_(seed, length(options), options.loop, options.hills_m),
      rate_hz_(options.rate_hz),
      height_m_(options.camera_height_m),
      pitch_rad_(options.pitch_rad) {
  s_.resize(static_cast<std::size_t>(options.frames));
  const double step = options.speed_mps / options.rate_hz;
  auto standstill = options.standstills.begin();
  double s = 0;
  for (int k = 0; k < options.frames; ++k) {
    while (standstill != options.standstills.end() && k >= standstill->first + standstill->frames) ++standstill;
    const bool stands = standstill != options.standstills.end() && k >= standstill->first;
    if (k > 0 && !stands) s += step * (1 + 0.06 * std::sin(0.031 * k) + 0.02 * std::sin(0.23 * k));
    s_[static_cast<std::size_t>(k)] = s;
  }
  Random random(hash(seed, 2));
  for (double& phase : phase_) phase = random.uniform(0, 6.2831853F);
}

int Drive::first_at(double s) const {
  return static_cast<int>(std::lower_bound(s_.begin(), s_.end(), s) - s_.begin());
}

double Drive::lateral(double s) const {
  return kLane + 0.22 * std::sin(0.035 * s + phase_[0]) + 0.08 * std::sin(0.11 * s + phase_[1]);
}

SE3 Drive::T_street_camera(int frame) const {
  // A car is not steered in steps: its place is the mean over some metres of the line that it follows. All of the
  // motion depends on the distance alone, so that a camera that stands still does so to the bit.
  const double s0 = s(frame);
  Eigen::Vector2d place(0, 0), before(0, 0), behind(0, 0);
  constexpr int kSamples = 24;
  constexpr double kStep = 0.25;
  for (int i = -kSamples; i <= kSamples; ++i) {
    const double at = s0 + i * kStep;
    const PathPoint p = path_.at(at, lateral(at));
    place += Eigen::Vector2d(p.x, p.z);
    if (i < 0) before += Eigen::Vector2d(p.x, p.z);
    if (i > 0) behind += Eigen::Vector2d(p.x, p.z);
  }
  const Eigen::Vector2d ahead = (behind - before).normalized();
  place /= 2 * kSamples + 1;
  const double rise = std::atan(path_.slope(s0));
  const double pitch =
      rise + pitch_rad_ + 0.003 * std::sin(0.9 * s0 + phase_[2]) + 0.001 * std::sin(2.1 * s0 + phase_[3]);
  const double roll = 0.004 * std::sin(0.57 * s0 + phase_[4]) + 0.002 * std::sin(1.7 * s0 + phase_[0]);
  const double bob = 0.012 * std::sin(0.8 * s0 + phase_[5]) + 0.006 * std::sin(1.9 * s0 + phase_[1]);
  Eigen::Matrix3d yaw, nod, tilt;
  yaw << ahead.y(), 0, ahead.x(), 0, 1, 0, -ahead.x(), 0, ahead.y();
  nod << 1, 0, 0, 0, std::cos(pitch), -std::sin(pitch), 0, std::sin(pitch), std::cos(pitch);
  tilt << std::cos(roll), -std::sin(roll), 0, std::sin(roll), std::cos(roll), 0, 0, 0, 1;
  // Over the road's own upright, which leans back where it rises.
  const double up = height_m_ - bob, back = up * std::sin(rise);
  return {yaw * nod * tilt,
          {place.x() - back * ahead.x(), -path_.height(s0) - up * std::cos(rise), place.y() - back * ahead.y()}};
}

}  // namespace pavo::synthetic
