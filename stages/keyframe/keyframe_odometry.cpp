#include "stages/keyframe/keyframe_odometry.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <stdexcept>
#include <utility>

#include "stages/keyframe/odometry_state.h"

namespace pavo {
void KeyframeOdometry::State::begin(const FrameTime& now, PoseResult& out, KeyframeRecord& record) {
  out.begin(published_T);
  stays = false;
  record.clear();
  record.frame = now.index;
  record.unit = unit;
  for (const Keyframe& k : keyframes) record.before.push_back({k.time.index, k.T_w_c});
}

// The map's keyframe has moved, and lengths may have changed: so does all that hangs on it.
void KeyframeOdometry::State::take_over(const MapUpdate& update) {
  if (!update.valid || !has_map) return;
  const auto it =
      std::find_if(keyframes.begin(), keyframes.end(), [&](const Keyframe& k) { return k.time.index == update.frame; });
  if (it == keyframes.end()) return;
  // By all that the map was scaled since the last update that came: live, there may have been others between.
  const double scale = update.unit / unit;
  unit = update.unit;
  camera = refined_camera(calibrated, update.lens);
  uncertainty.take_over(update, scale);
  scale_known = scale_known || update.scale_variance >= 0;
  if (ground) *ground /= scale;
  if (update.ground && update.scale_variance < options.sure_of_ground * options.sure_of_ground) ground = update.ground;
  const SE3 old = it->T_w_c;
  const Eigen::Matrix3d R = update.T_w_c.R * old.R.transpose();
  const auto moved = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    return update.T_w_c.t + scale * (R * (p - old.t));
  };
  const auto move_pose = [&](SE3& T) {
    T.R = Eigen::Quaterniond(R * T.R).normalized().toRotationMatrix();
    T.t = moved(T.t);
  };
  move_pose(last_T);
  for (Keyframe& k : keyframes) move_pose(k.T_w_c);
  it->T_w_c = update.T_w_c;
  motion_model.scale(scale);
  median_rho /= scale, high_rho /= scale;
  for (TrackedPoint& p : points) {
    if (p.id == 0) continue;
    p.ray.origin = moved(p.ray.origin);
    p.ray.direction = R * p.ray.direction;
    p.ray.rho /= scale, p.ray.sigma_rho /= scale;
    p.patch_position = moved(p.patch_position);
    p.patch_axis = R * p.patch_axis;
  }
  by_id.clear();
  for (TrackedPoint& p : points)
    if (p.id != 0) by_id.emplace_back(p.id, &p);
  std::ranges::sort(by_id);
  for (const MapUpdate::Point& known : update.points) {
    const auto place = std::ranges::lower_bound(by_id, known.point, {}, [](const auto& entry) { return entry.first; });
    if (place == by_id.end() || place->first != known.point) continue;
    if (known.good)
      place->second->ray = known.ray;
    else
      place->second->id = 0;
  }
  keyframes.erase(keyframes.begin(), it);
}

void KeyframeOdometry::State::drop_features_on_people(const Features& features, const People& people, PoseResult& out) {
  out.keypoints = static_cast<int>(features.size());
  out.kept.resize(features.size());
  out.dropped_on_people =
      static_cast<int>(features_on_people(features.keypoints, people, out.kept, options.people_mask));
}

void KeyframeOdometry::State::report(PoseResult& out) {
  out.pairs.clear();
  out.is_inlier.clear();
  out.inliers = 0;
  for (const TrackedPoint& point : points) {
    const bool found = point.now == TrackedPoint::Now::found || point.now == TrackedPoint::Now::fits;
    if (!found || point.id == 0 || point.seen < 2) continue;
    out.pairs.push_back({point.last_px.x(), point.last_px.y(), point.px.x(), point.px.y()});
    out.is_inlier.push_back(point.now == TrackedPoint::Now::fits || out.quality == Quality::standing);
    out.inliers += out.is_inlier.back();
  }
  out.matches = static_cast<int>(out.pairs.size());
}

bool KeyframeOdometry::State::follow(const FrameTime& now, const FrameView& current, const FrameView& previous,
                                     const People& people, PoseResult& out, KeyframeRecord& record) {
  search.build(*current.features, out.kept, camera.width, camera.height);
  const PosePrior prior = expected(now);
  SE3 T;
  find_pose(now, current, previous, prior, T, out);
  align_points(T, current, people);
  out.reference_frame = last_time.index;
  if (standing(out)) {
    report(out);
    motion_model.observe(SE3{}, last_time, now);
    stood = true;
    return true;
  }
  const RefinedPose fine = pose_of_found(prior, T);
  if (fine.inliers < points_needed(prior, fine.T_w_c) ||
      fine.inliers < options.min_agreement * static_cast<double>(constraints.size())) {
    out.reason = PoseReason::too_few_inliers;
    report(out);
    return false;
  }
  stood = false;
  tell_uncertainty(fine);
  out.T_w_c = fine.T_w_c;
  out.quality = Quality::tracked;
  update_points(fine.T_w_c, current);
  report(out);
  out.step_m = (out.T_w_c.t - last_T.t).norm();
  motion_model.observe(last_T.inverse() * out.T_w_c, last_time, now);
  record.followed = true;
  record.T_last_c = keyframes.back().T_w_c.inverse() * out.T_w_c;
  if (wants_keyframe()) make_keyframe(now, current, out.T_w_c, record, out);
  for (TrackedPoint& point : points) {
    point.in_still = point.id != 0 && point.now == TrackedPoint::Now::fits;
    if (point.in_still) point.still_px = point.px;
  }
  return true;
}

void KeyframeOdometry::State::coast(const FrameTime& now, PoseResult& out) {
  const SE3 step = motion_model.predict(last_time, now);
  out.quality = Quality::coasting;
  stays = !started || (step.R.isIdentity(0) && step.t.isZero(0));
  if (stays) return;  // at rest: to the bit
  out.T_w_c = last_T * step;
  out.T_w_c.R = Eigen::Quaterniond(out.T_w_c.R).normalized().toRotationMatrix();
  out.step_m = step.t.norm();
}

void KeyframeOdometry::State::end(const FrameTime& now, bool estimated, PoseResult& out) {
  if (out.quality == Quality::coasting || out.quality == Quality::relocalising) guess_uncertainty(out);
  out.covariance = uncertainty.covariance(out.T_w_c);
  out.has_covariance = true;
  last_time = now;
  published_T = out.T_w_c;
  if (!stays) last_T = out.T_w_c;
  last_kept.assign(out.kept.begin(), out.kept.end());
  lost = estimated ? 0 : lost + 1;
  for (TrackedPoint& point : points)
    if (point.id != 0 && (point.now == TrackedPoint::Now::found || point.now == TrackedPoint::Now::fits))
      point.last_px = point.px;
}

KeyframeOdometry::KeyframeOdometry(const Camera& camera, const KeyframeOdometryOptions& options,
                                   std::shared_ptr<const StepLength> step_length)
    : state_(std::make_unique<State>(camera, options, std::move(step_length))) {
  state_->keyframes.reserve(16);
}
KeyframeOdometry::~KeyframeOdometry() = default;
KeyframeOdometry::KeyframeOdometry(KeyframeOdometry&&) noexcept = default;
KeyframeOdometry& KeyframeOdometry::operator=(KeyframeOdometry&&) noexcept = default;

void KeyframeOdometry::operator()(const FrameTime& now, const FrameView& current, const FrameView& previous,
                                  const People& people, const MapUpdate* update, PoseResult& out,
                                  KeyframeRecord& record) {
  State& s = *state_;
  if (!current.features || !current.image)
    throw std::invalid_argument("odometry: the current frame has no features or no image; call missed()");
  if (update) s.take_over(*update);
  s.begin(now, out, record);
  if (update) record.adjusted.assign(update->window.begin(), update->window.end());
  s.drop_features_on_people(*current.features, people, out);
  const bool usable = out.keypoints - out.dropped_on_people >= s.options.motion.min_matches;
  bool estimated = false;
  if (!usable) {
    out.reason = out.keypoints >= s.options.motion.min_matches ? PoseReason::too_few_after_people
                                                               : PoseReason::too_few_keypoints;
  } else if (!s.started) {
    s.started = estimated = true;
    out.quality = Quality::tracked;
    out.reason = PoseReason::first_frame;
    s.set_reference(now, current, out, record);
  } else if (s.has_map) {
    estimated = s.follow(now, current, previous, people, out, record);
  } else {
    estimated = s.start(now, current, out, record);
  }
  if (!estimated) {
    s.coast(now, out);
    const int patience = s.stood ? s.options.lost_after_standing : s.options.lost_after;
    if (usable && s.started && s.lost + 1 >= patience) {
      s.has_map = s.stays = false;
      s.ground.reset();
      s.carried.forget();
      s.set_reference(now, current, out, record);
      s.lost = -1;
      out.quality = Quality::relocalising;
    }
  }
  s.end(now, estimated, out);
}

void KeyframeOdometry::missed(const FrameTime& now, const FrameView&, const MapUpdate* update, PoseResult& out,
                              KeyframeRecord& record) {
  State& s = *state_;
  if (update) s.take_over(*update);
  s.begin(now, out, record);
  if (update) record.adjusted.assign(update->window.begin(), update->window.end());
  out.reason = PoseReason::missed;
  s.coast(now, out);
  s.end(now, false, out);
}

}  // namespace pavo
