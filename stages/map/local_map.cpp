#include "stages/map/local_map.h"

#include <Eigen/LU>
#include <stdexcept>

namespace pavo {

LocalMap::LocalMap(const Camera& camera, const LocalMapOptions& options)
    : camera_(camera),
      options_(options),
      adjust_(camera, options.bundle),
      window_(static_cast<std::size_t>(options.window)),
      points_(kTable) {
  if (options.window < 3 || options.window > Bundle::kMaxFree || options.fixed < 2 || options.fixed >= options.window)
    throw std::invalid_argument("map: expected a window of 3 to 16 keyframes, of which at least 2 are fixed");
  if (options.refine_lens) lens_information_ = options.lens_sigma.cwiseAbs2().cwiseInverse().asDiagonal();
}

void LocalMap::add(const KeyframeRecord& record, double unit) {
  const std::optional<SE3> hangs = in_newest(record);
  if (!hangs) reset();
  insert(record, hangs, unit);
  build();
  if (bundle_.points.size() < 10 || count_ < 2) return;
  const BundleSummary summary = adjust_(bundle_);
  take_over();
  if (options_.refine_lens) learn_lens(summary.lens_information);
  cull();
}

// A Kalman filter: what the window says, without what was known. An observation is in as many windows as there are
// keyframes in one, and is to count once.
void LocalMap::learn_lens(const Eigen::Matrix2d& information) {
  const Eigen::Matrix2d said = (information - lens_information_) / options_.window;
  const Eigen::Vector2d pull = (information * bundle_.lens - lens_information_ * lens_) / options_.window;
  const Eigen::Matrix2d sum = lens_information_ + said;
  const LensError learnt = sum.inverse() * (lens_information_ * lens_ + pull);
  if (!learnt.allFinite()) return;
  lens_ = learnt;
  Eigen::Matrix2d covariance = sum.inverse();
  covariance.diagonal() += 0.01 * options_.lens_least_sigma.cwiseAbs2();
  lens_information_ = covariance.inverse();
}

LocalMap::Point* LocalMap::find(PointId id) {
  Point& point = points_[id % kTable];
  return point.id == id && id != 0 ? &point : nullptr;
}

void LocalMap::reset() {
  for (Point& point : points_) point.id = 0;
  first_ = count_ = 0;
}

bool LocalMap::is_next(const KeyframeRecord& record) const {
  if (count_ == 0 || record.restart) return false;
  return record.before.empty() || record.before.back().frame == newest_frame();
}

std::optional<SE3> LocalMap::in_newest(const KeyframeRecord& record) const {
  if (is_next(record)) return record.T_last_c;
  if (count_ == 0 || record.restart) return std::nullopt;
  for (const KeyframePose& k : record.before)
    if (k.frame == newest_frame()) return k.T_w_c.inverse() * record.T_w_c;
  return std::nullopt;
}

void LocalMap::insert(const KeyframeRecord& record, const std::optional<SE3>& in_newest, double unit) {
  const SE3 T = in_newest ? newest_pose() * SE3{in_newest->R, unit * in_newest->t} : record.T_w_c;
  if (is_next(record))
    for (const KeyframeRecord::Observation& seen : record.in_last_keyframe)
      window_[keyframe(count_ - 1)].observations.push_back({seen.point, seen.x, seen.y, 1 / seen.sigma_px});
  if (count_ == window_.size()) {
    first_ = (first_ + 1) % window_.size();
    --count_;
  }
  Keyframe& now = window_[keyframe(count_++)];
  now.frame = record.frame;
  now.T_w_c = moved_by(T, Vector6d::Zero());
  for (const KeyframeRecord::NewPoint& added : record.new_points) {
    Point& point = points_[added.point % kTable];
    point = {.id = added.point, .ray = added.in_keyframe, .good = true, .count = 0, .bundle = -1};
    point.ray.origin = T * (unit * added.in_keyframe.origin);
    point.ray.direction = T.R * added.in_keyframe.direction;
    point.ray.rho /= unit, point.ray.sigma_rho /= unit;
  }
  now.observations.clear();
  for (const KeyframeRecord::Observation& seen : record.observations)
    now.observations.push_back({seen.point, seen.x, seen.y, 1 / seen.sigma_px});
}

// Points seen by two keyframes or more, of which one is free. Observations sorted by point.
void LocalMap::build() {
  bundle_.clear();
  bundle_.lens = bundle_.prior_lens = lens_;
  bundle_.lens_information = lens_information_;
  order_.clear();
  for (std::size_t i = 0; i < count_; ++i)
    bundle_.poses.push_back(
        {window_[keyframe(i)].T_w_c, i < static_cast<std::size_t>(options_.fixed) && i + 1 < count_});
  if (count_ == 2) bundle_.poses[1].fixed = false;
  for (std::size_t i = 0; i < count_; ++i)
    for (const Observation& z : window_[keyframe(i)].observations)
      if (Point* point = find(z.point)) point->count = 0, point->bundle = -1;
  for (std::size_t i = 0; i < count_; ++i)
    for (const Observation& z : window_[keyframe(i)].observations)
      if (Point* point = find(z.point)) ++point->count;
  int total = 0;
  for (std::size_t i = count_; i-- > 0;) {
    if (bundle_.poses[i].fixed) continue;
    for (const Observation& z : window_[keyframe(i)].observations) {
      Point* point = find(z.point);
      if (!point || !point->good || point->bundle >= 0 || point->count < 2) continue;
      point->bundle = static_cast<int>(bundle_.points.size());
      bundle_.points.push_back({.ray = point->ray, .first = total, .count = 0, .prior_rho = 0, .prior_information = 0});
      order_.push_back(z.point);
      total += point->count;
    }
  }
  bundle_.observations.resize(static_cast<std::size_t>(total));
  for (std::size_t i = 0; i < count_; ++i) {
    for (const Observation& z : window_[keyframe(i)].observations) {
      const Point* point = find(z.point);
      if (!point || point->bundle < 0) continue;
      BundlePoint& into = bundle_.points[point->bundle];
      bundle_.observations[into.first + into.count++] = {static_cast<int>(i), point->bundle, z.x, z.y, z.inverse_sigma};
    }
  }
}

void LocalMap::take_over() {
  for (std::size_t i = 0; i < count_; ++i) window_[keyframe(i)].T_w_c = bundle_.poses[i].T_w_c;
  for (std::size_t k = 0; k < order_.size(); ++k) find(order_[k])->ray = bundle_.points[k].ray;
}

// Observations that do not fit are wrong; a point with more wrong ones than right ones, or behind where it was seen
// from, is none.
void LocalMap::cull() {
  cursor_.assign(order_.size(), 0);
  const Camera camera = refined_camera(camera_, bundle_.lens);
  for (std::size_t i = 0; i < count_; ++i) {
    Keyframe& frame = window_[keyframe(i)];
    std::size_t kept = 0;
    for (const Observation& z : frame.observations) {
      const Point* point = find(z.point);
      if (!point) continue;
      bool fits = true;
      if (point->bundle >= 0) {
        const Eigen::Vector3d p = scaled_in_camera(point->ray, frame.T_w_c);
        fits = p.z() > 1e-3 && (pixel_of(camera, p) - Eigen::Vector2d(z.x, z.y)).norm() < options_.outlier_px;
        cursor_[point->bundle] += fits ? 0 : 1;
      }
      if (fits) frame.observations[kept++] = z;
    }
    frame.observations.resize(kept);
  }
  for (std::size_t k = 0; k < order_.size(); ++k) {
    Point& point = *find(order_[k]);
    const int wrong = cursor_[k], right = point.count - wrong;
    point.good = right >= 2 && wrong < right && point.ray.rho > -3 * point.ray.sigma_rho;
  }
}

double LocalMap::newest_baseline() const {
  return count_ < 2 ? 0 : (newest_pose().t - window_[keyframe(count_ - 2)].T_w_c.t).norm();
}

void LocalMap::rescale(double factor) {
  const Eigen::Vector3d fixed = newest_pose().t;
  for (std::size_t i = 0; i < count_; ++i) {
    SE3& T = window_[keyframe(i)].T_w_c;
    T.t = fixed + factor * (T.t - fixed);
  }
  for (Point& point : points_) {
    if (point.id == 0) continue;
    point.ray.origin = fixed + factor * (point.ray.origin - fixed);
    point.ray.rho /= factor;
    point.ray.sigma_rho /= factor;
  }
}

void LocalMap::report(MapUpdate& update) const {
  update.clear();
  update.valid = true;
  update.frame = newest_frame();
  update.T_w_c = newest_pose();
  update.lens = lens_;
  for (std::size_t i = 0; i < count_; ++i)
    update.window.push_back({window_[keyframe(i)].frame, window_[keyframe(i)].T_w_c});
  for (const PointId id : order_) {
    const Point& point = points_[id % kTable];
    update.points.push_back({id, point.ray, point.good});
  }
}

}  // namespace pavo
