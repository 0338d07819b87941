#include "stages/keyframe/odometry_state.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "stages/pose/essential.h"

namespace pavo {
namespace {

void copy(const Features& from, Features& to) {
  to.reserve(from.size());
  to.keypoints = from.keypoints;
  std::memcpy(to.descriptors.get(), from.descriptors.get(), from.size() * Features::kDescriptorSize * sizeof(float));
}

void copy(const Image& from, Image& to) {
  to.resize(from.width(), from.height());
  for (int y = 0; y < from.height(); ++y) std::memcpy(to.row(y), from.row(y), static_cast<std::size_t>(from.width()));
}

}  // namespace

void KeyframeOdometry::State::set_reference(const FrameTime& now, const FrameView& current, const PoseResult& out,
                                            KeyframeRecord& record) {
  has_reference = true;
  has_scale = false;
  uncertainty.begin_map();
  reference_time = reference_still = now;
  reference_T = out.T_w_c;
  copy(*current.features, reference_features);
  copy(*current.image, reference_image);
  reference_kept.assign(out.kept.begin(), out.kept.end());
  reference_matches = 0;
  for (TrackedPoint& p : points) p.id = 0;
  keyframes.clear();
  record.is_keyframe = record.restart = true;
  record.T_w_c = record.T_last_c = out.T_w_c;
  keyframes.push_back({now, out.T_w_c});
}

// One match a cell of the picture: the first. (The one whose descriptors are most alike is too often on what does not
// move in the picture: behind a car ahead the start then follows the car.)
void KeyframeOdometry::State::thin_matches(const Features& now) {
  grid.clear();
  std::erase_if(matches, [&](const Match& match) {
    const Keypoint& k = now.keypoints[static_cast<std::size_t>(match.current)];
    return !grid.take(k.x, k.y);
  });
}

// Frame to frame against the reference, until the points have depths.
bool KeyframeOdometry::State::start(const FrameTime& now, const FrameView& current, PoseResult& out,
                                    KeyframeRecord& record) {
  out.reference_frame = reference_time.index;
  match_nearest(reference_features, *current.features, reference_kept, out.kept, matches, nearest_scratch);
  thin_matches(*current.features);
  pairs_of(matches, reference_features, *current.features, out.pairs);
  refined.resize(out.pairs.size());
  refine_subpixel(reference_image.view(), current.image->view(), out.pairs, refined);
  out.matches = static_cast<int>(out.pairs.size());
  if (reference_matches == 0) reference_matches = out.matches;
  RelativeMotion motion = relative_motion(out.pairs, Random::for_frame(options.seed, now.index), out.is_inlier);
  out.inliers = motion.inliers;
  out.reason = motion.reason;
  if (!motion.found) return false;
  out.quality = motion.quality;
  if (motion.quality == Quality::standing) {
    out.T_w_c = reference_T;
    reference_still = now;
    motion_model.observe(SE3{}, reference_still, now);
    return true;
  }
  const Eigen::Vector3d guess = motion_model.predict(reference_still, now).t;
  double metres = step_length->metres(
      {reference_time.index, reference_still.index, now.index, reference_time.t_ns, reference_still.t_ns, now.t_ns});
  if (!step_length->metric() && guess.norm() > 0) metres = guess.norm();
  const bool told = std::isfinite(metres) && metres >= 0;
  if (!told) metres = guess.norm() > 0 ? guess.norm() : 1;
  if (motion.reason == PoseReason::rotation_only) metres = 0;
  motion.T_p_c.t *= metres;
  out.step_m = metres;
  out.T_w_c = reference_T * motion.T_p_c;
  out.T_w_c.R = Eigen::Quaterniond(out.T_w_c.R).normalized().toRotationMatrix();
  if (!has_scale) begin_scale(told);
  tell_uncertainty_of_start(motion.T_p_c, out);
  motion_model.observe(motion.T_p_c, reference_still, now);
  int clear = 0;
  for (std::size_t i = 0; i < out.pairs.size(); ++i)
    clear += out.is_inlier[i] && parallax_px(motion.T_p_c.inverse(), out.pairs[i], camera) > options.start_parallax_px;
  if (metres > 0 && clear >= std::max(options.min_tracked, out.inliers / 4)) {
    make_first_points(current, out.T_w_c, out, record);
    keyframes.push_back({now, out.T_w_c});
    record.is_keyframe = true;
    record.T_w_c = out.T_w_c;
    record.T_last_c = reference_T.inverse() * out.T_w_c;
    has_map = true;
    has_reference = false;
  } else if (now.index - reference_time.index > 10 || out.matches < reference_matches / 2) {
    set_reference(now, current, out, record);
  }
  return true;
}

void KeyframeOdometry::State::make_first_points(const FrameView& current, const SE3& T_w_c, PoseResult& out,
                                                KeyframeRecord& record) {
  const SE3 T_c_r = T_w_c.inverse() * reference_T;
  tracked_at_keyframe = 0;
  for (std::size_t i = 0; i < out.pairs.size(); ++i) {
    if (!out.is_inlier[i] || !refined[i]) continue;
    const PointPair& pair = out.pairs[i];
    const Eigen::Vector3d ray_r = ray_of(camera, pair.x_previous, pair.y_previous);
    TrackedPoint* p = free_point();
    if (!p || !take_patch(reference_image.view(), pair.x_previous, pair.y_previous, p->patch)) continue;
    p->id = next_id++;
    p->ray = {reference_T.t, reference_T.R * ray_r, median_rho, 1e3};
    p->patch_position = reference_T.t;
    p->patch_axis = reference_T.R.col(2);
    std::copy_n(current.features->descriptor(matches[i].current), Features::kDescriptorSize, p->descriptor.begin());
    p->px = p->last_px = p->keyframe_px = p->still_px = {pair.x_current, pair.y_current};
    p->in_keyframe = p->in_still = p->in_map = true;
    p->seen = 2, p->misses = p->outliers = 0;
    p->now = TrackedPoint::Now::fits;
    // Linear start: the point on the epipolar line.
    const Depths depths = triangulate_depths(T_c_r, ray_r, ray_of(camera, pair.x_current, pair.y_current));
    p->ray.rho = std::isfinite(depths.previous) && depths.previous > 0 ? 1 / depths.previous : 0;
    update_depth(*p, T_w_c);
    if (p->ray.rho < -2 * p->ray.sigma_rho || !(p->ray.sigma_rho < 1e2)) {
      p->id = 0;
      continue;
    }
    p->ray.rho = std::max(p->ray.rho, 0.0);
    const SE3 T_c_w = T_w_c.inverse();
    record.new_points.push_back(
        {p->id, {T_c_w * p->ray.origin, T_c_w.R * p->ray.direction, p->ray.rho, p->ray.sigma_rho}});
    const auto sigma = static_cast<float>(options.sigma_px);
    record.in_last_keyframe.push_back({p->id, pair.x_previous, pair.y_previous, sigma});
    record.observations.push_back({p->id, pair.x_current, pair.y_current, sigma});
    ++tracked_at_keyframe;
  }
}

}  // namespace pavo
