#include "drivers/synthetic/walkers.h"

#include <algorithm>
#include <cmath>

#include "drivers/synthetic/layout.h"

namespace pavo::synthetic {
namespace {

constexpr double kNear = -6, kFar = 75;  ///< metres along the street in which people are shown

struct Place {
  double s, l;
};

/// Where a passer-by is at time t.
Place place_at(const Walker& w, double t) {
  if (!w.crosses) return {w.s0 + w.before * w.speed_mps * (t - w.t_cross), w.l0};
  const double duration = std::abs(w.l1 - w.l0) / w.speed_mps, since = t - w.t_cross;
  if (since < 0) return {w.s0 + w.before * w.speed_mps * since, w.l0};
  if (since < duration) return {w.s0, w.l0 + (w.l1 - w.l0) * since / duration};
  return {w.s0 + w.after * w.speed_mps * (since - duration), w.l1};
}

double ground_y(const Path& path, double s, double l) {
  return -path.height(s) - (std::abs(l) > kKerb ? kKerbHeight : 0);
}

}  // namespace

Walkers::Walkers(const SyntheticOptions& options, const Drive& drive, std::uint32_t seed) {
  Random random(hash(seed, 3));
  if (options.people) add_passers_by(options, drive, seed, random);
  Random beside(hash(seed, 4));
  add_companions(options.companions, beside);
}

/// Nobody crosses the way of the car closer than he would dare.
bool Walkers::is_safe(const Walker& w, const Drive& drive) const {
  for (int k = drive.first_at(w.s0 - 12); k < drive.frames() && drive.s(k) < w.s0 + 12; ++k) {
    const Place p = place_at(w, drive.time(k));
    if (std::abs(p.l - drive.lateral(drive.s(k))) > 1.7) continue;
    const double gap = p.s - drive.s(k);
    if (gap > -1.5 && gap < 5.5) return false;
  }
  return true;
}

void Walkers::add_passers_by(const SyntheticOptions& options, const Drive& drive, std::uint32_t seed, Random& random) {
  const int frames = drive.frames();
  const double metres = drive.s(frames - 1) + 60;
  const int count = static_cast<int>(std::lround(options.density * 0.14 * metres)) + (options.density > 0 ? 4 : 0);
  for (int i = 0; i < count; ++i) {
    Walker w;
    w.look_seed = random.bits();
    w.crosses = i % 2 == 0;
    for (int attempt = 0; attempt < 20; ++attempt) {
      // They are met in some frame: then they stand some metres ahead of the camera.
      const int k = random.below(frames);
      const double side = random.chance(0.5F) ? 1 : -1;
      w.speed_mps = random.uniform(0.8F, 1.8F);
      w.l0 = side * random.uniform(5.9F, 7.6F);
      w.l1 = -side * random.uniform(5.9F, 7.6F);
      w.before = random.chance(0.5F) ? 1 : -1;
      w.after = random.chance(0.5F) ? 1 : -1;
      w.s0 = drive.s(k) + random.uniform(7, 26);
      if (w.crosses) w.s0 = (std::floor(w.s0 / kParkingSlot) + 0.5) * kParkingSlot;
      w.t_cross = drive.time(k) - (w.crosses ? random.uniform(0.1F, 0.9F) * (std::abs(w.l1 - w.l0) / w.speed_mps) : 0);
      const bool blocked = is_parked(seed, drive.path(), w.s0, 1) || is_parked(seed, drive.path(), w.s0, -1);
      if (w.crosses && (blocked || !is_safe(w, drive))) continue;
      w.id = static_cast<int>(walkers_.size());
      walkers_.push_back(w);
      break;
    }
  }
}

void Walkers::add_companions(int count, Random& random) {
  for (int i = 0; i < count; ++i) {
    Walker w;
    w.companion = true;
    w.look_seed = random.bits();
    for (int attempt = 0; attempt < 40; ++attempt) {
      w.ahead = random.uniform(4.2F, 10.0F);
      // in the lanes, or on the right sidewalk: between them cars are parked
      const bool sidewalk = w.ahead > 6.5 && random.chance(0.2F);
      w.beside = sidewalk ? random.uniform(4.6F, 5.7F)
                          : std::clamp<double>(random.uniform(-0.75F, 0.45F) * static_cast<float>(w.ahead), -3.9, 0.9);
      const bool free = std::none_of(walkers_.begin(), walkers_.end(), [&](const Walker& other) {
        return other.companion && std::hypot(other.ahead - w.ahead, other.beside - w.beside) < 0.75;
      });
      if (free) break;
    }
    w.sway = random.uniform(0.01F, 0.04F);
    w.phase = random.uniform(0, 6.2831853F);
    w.id = static_cast<int>(walkers_.size());
    walkers_.push_back(w);
  }
}

bool Walkers::stride(const Walker& w, int frame, const Drive& drive, Stride& out) const {
  const double s = drive.s(frame), t = drive.time(frame);
  if (w.companion) {
    const double rhythm = 2 * 3.14159265 * 0.13 / 0.8 * s + w.phase;  // a step every four frames at 0.8 m a frame
    const PathPoint p = drive.path().at(s + w.ahead + w.sway * std::sin(rhythm),
                                        drive.lateral(s) + w.beside + w.sway * std::sin(0.5 * rhythm));
    const double l = drive.lateral(s) + w.beside;
    out = {{p.x, ground_y(drive.path(), s + w.ahead, l), p.z}, p.heading, rhythm, 1.4};
    return true;
  }
  const Place now = place_at(w, t);
  if (now.s - s < kNear || now.s - s > kFar) return false;
  // the way is rounded off at its corners: the mean over a second
  Eigen::Vector2d place(0, 0), past(0, 0), future(0, 0);
  double along = 0, l = 0;
  for (int i = -5; i <= 5; ++i) {
    const Place at = place_at(w, t + 0.1 * i);
    const PathPoint p = drive.path().at(at.s, at.l);
    place += Eigen::Vector2d(p.x, p.z) / 11;
    along += at.s / 11;
    l += at.l / 11;
    if (i < 0) past += Eigen::Vector2d(p.x, p.z);
    if (i > 0) future += Eigen::Vector2d(p.x, p.z);
  }
  const Eigen::Vector2d ahead = future - past;
  const double heading = std::atan2(ahead.x(), ahead.y());
  out = {{place.x(), ground_y(drive.path(), along, l), place.y()},
         heading,
         2 * 3.14159265 * w.speed_mps * t / stride_length(w.speed_mps) + w.phase + w.id,
         w.speed_mps};
  return true;
}

}  // namespace pavo::synthetic
