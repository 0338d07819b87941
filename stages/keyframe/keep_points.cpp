#include "stages/keyframe/odometry_state.h"

#include <algorithm>
#include <cmath>

namespace pavo {
TrackedPoint* KeyframeOdometry::State::free_point() {
  for (TrackedPoint& p : points)
    if (p.id == 0) return &p;
  return nullptr;
}

// rho given the pixel, the pose held: Gauss-Newton on one number, the former estimate as prior.
void KeyframeOdometry::State::update_depth(TrackedPoint& point, const SE3& T) const {
  const double prior_rho = point.ray.rho, prior_information = 1 / (point.ray.sigma_rho * point.ray.sigma_rho);
  const Eigen::Vector3d by_rho = T.R.transpose() * (point.ray.origin - T.t);
  const Eigen::Vector3d direction = T.R.transpose() * point.ray.direction;
  const double information_px = 1 / (options.sigma_px * options.sigma_px);
  double rho = prior_rho, H = prior_information;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d p = direction + rho * by_rho;
    if (p.z() < 1e-3) return;
    const Eigen::Vector2d g = pixel_jacobian(camera, p) * by_rho;
    const Eigen::Vector2d r = pixel_of(camera, p) - point.px.cast<double>();
    H = prior_information + information_px * g.squaredNorm();
    const double step = (prior_information * (rho - prior_rho) + information_px * g.dot(r)) / H;
    rho -= step;
    if (std::abs(step) < 1e-3 / std::sqrt(H)) break;
  }
  point.ray.rho = rho;
  point.ray.sigma_rho = 1 / std::sqrt(H);
}

// Nothing is seen through the ground. What keeps its place in the picture while the camera drives (a car ahead,
// somebody who walks along) seems to be infinitely far, and where the ground would have to be in front of it that is
// not so.
bool KeyframeOdometry::State::is_below_ground(const RayPoint& ray, const SE3& T) const {
  if (!ground) return false;
  const Eigen::Vector3d p = scaled_in_camera(ray, T);
  const double ground_rho = ground->dot(p) - options.ground_slack_rad * ground->norm() * p.z();
  return options.farthest_below * (ray.rho + 2 * ray.sigma_rho) < ground_rho;
}

void KeyframeOdometry::State::update_points(const SE3& T, const FrameView& current) {
  carried.fade();
  for (std::size_t n = 0; n < constrained.size(); ++n) {
    TrackedPoint& point = points[constrained[n]];
    if (constraints.chi2(n) > 9) {
      if (++point.outliers >= 2) point.id = 0;
      ++point.misses;
      continue;
    }
    point.now = TrackedPoint::Now::fits;
    point.misses = 0;
    ++point.seen;
    point.outliers = std::max(0, point.outliers - 1);
    update_depth(point, T);
    const bool below = is_below_ground(point.ray, T);
    if (below) carried.add(point.px.x(), point.px.y());
    if (below || point.ray.rho < -2 * point.ray.sigma_rho) {
      point.id = 0;
      continue;
    }
    const double scale = point.patch_scale(T);
    if (scale > options.new_patch_ratio || scale * options.new_patch_ratio < 1) {
      if (take_patch(current.image->view(), point.px.x(), point.px.y(), point.patch)) {
        point.patch_position = T.t;
        point.patch_axis = T.R.col(2);
      }
    }
  }
  for (TrackedPoint& point : points) {
    if (point.id == 0) continue;
    if (point.now == TrackedPoint::Now::hidden || point.now == TrackedPoint::Now::searched) {
      const int limit = point.seen < 2 ? 2 : options.max_misses;
      if (++point.misses >= limit) point.id = 0;
    }
  }
}

bool KeyframeOdometry::State::wants_keyframe() const {
  auto& motions = const_cast<std::vector<float>&>(scratch);
  motions.clear();
  int tracked = 0;
  for (const TrackedPoint& point : points) {
    if (point.id == 0 || point.now != TrackedPoint::Now::fits) continue;
    ++tracked;
    if (point.in_keyframe) motions.push_back((point.px - point.keyframe_px).norm());
  }
  if (tracked < options.keyframe_share * tracked_at_keyframe || motions.size() < 20) return true;
  std::nth_element(motions.begin(), motions.begin() + static_cast<std::ptrdiff_t>(motions.size() / 2), motions.end());
  return motions[motions.size() / 2] > options.keyframe_px;
}

void KeyframeOdometry::State::make_keyframe(const FrameTime& now, const FrameView& current, const SE3& T,
                                            KeyframeRecord& record, const PoseResult& out) {
  record.is_keyframe = true;
  record.T_w_c = T;
  const Keyframe& last = keyframes.back();
  if (step_length->metric()) {
    const double metres =
        step_length->metres({last.time.index, last.time.index, now.index, last.time.t_ns, last.time.t_ns, now.t_ns});
    if (std::isfinite(metres) && metres > 0) record.baseline_m = metres, record.baseline_log_sigma = 0.03;
  }
  tracked_at_keyframe = 0;
  scratch.clear();
  for (TrackedPoint& point : points) {
    if (point.id == 0) continue;
    point.in_keyframe = point.now == TrackedPoint::Now::fits;
    if (!point.in_keyframe) continue;
    point.keyframe_px = point.px;
    ++tracked_at_keyframe;
    record.observations.push_back({point.id, point.px.x(), point.px.y(), static_cast<float>(options.sigma_px)});
    const double depth = T.R.col(2).dot(point.ray.direction + point.ray.rho * (point.ray.origin - T.t));
    scratch.push_back(static_cast<float>(point.ray.rho / depth));
  }
  if (scratch.size() >= 20) {
    const auto at = [&](double share) {
      const auto place = scratch.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(scratch.size()));
      std::nth_element(scratch.begin(), place, scratch.end());
      return static_cast<double>(*place);
    };
    median_rho = std::max(1e-6, at(0.5));
    high_rho = std::max(2 * median_rho, 1.5 * at(0.97));
  }
  add_points(current, T, record, out);
  if (keyframes.size() == keyframes.capacity()) keyframes.erase(keyframes.begin());
  keyframes.push_back({now, T});
}

// The strongest keypoints of the places where no point is followed yet.
void KeyframeOdometry::State::add_points(const FrameView& current, const SE3& T, KeyframeRecord& record,
                                         const PoseResult& out) {
  grid.clear();
  int alive = 0;
  for (const TrackedPoint& point : points) {
    if (point.id == 0 || point.now != TrackedPoint::Now::fits) continue;
    ++alive;
    grid.take(point.px.x(), point.px.y());
  }
  const Features& features = *current.features;
  candidates.clear();
  for (std::size_t i = 0; i < features.size(); ++i) {
    const Keypoint& k = features.keypoints[i];
    if (out.kept[i] && !grid.is_taken(k.x, k.y)) candidates.push_back(static_cast<int>(i));
  }
  std::sort(candidates.begin(), candidates.end(), [&](int a, int b) {
    const float x = features.keypoints[a].response, y = features.keypoints[b].response;
    return x != y ? x > y : a < b;  // stable, without the memory that std::stable_sort asks for
  });
  for (const int i : candidates) {
    if (alive >= options.max_points) break;
    const Keypoint& k = features.keypoints[i];
    if (grid.is_taken(k.x, k.y) || carried.holds(k.x, k.y)) continue;
    TrackedPoint* point = free_point();
    if (!point) break;
    if (!take_patch(current.image->view(), k.x, k.y, point->patch)) continue;
    grid.take(k.x, k.y);
    ++alive;
    const Eigen::Vector3d ray = ray_of(camera, k.x, k.y);
    point->id = next_id++;
    point->ray = {T.t, T.R * ray, high_rho / 2, high_rho / 4};
    point->patch_position = T.t;
    point->patch_axis = T.R.col(2);
    std::copy_n(features.descriptor(i), Features::kDescriptorSize, point->descriptor.begin());
    point->px = point->last_px = point->keyframe_px = point->still_px = {k.x, k.y};
    point->in_keyframe = point->in_still = true;
    point->in_map = true;
    point->seen = 1, point->misses = point->outliers = 0;
    point->now = TrackedPoint::Now::fits;
    ++tracked_at_keyframe;
    record.new_points.push_back({point->id, {Eigen::Vector3d::Zero(), ray, point->ray.rho, point->ray.sigma_rho}});
    record.observations.push_back({point->id, k.x, k.y, static_cast<float>(options.sigma_px)});
  }
}

}  // namespace pavo
