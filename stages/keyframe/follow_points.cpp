#include "stages/keyframe/odometry_state.h"

#include <algorithm>
#include <cmath>

#include "stages/pose/standstill.h"

namespace pavo {
namespace {

bool on_person(const Eigen::Vector2f& px, const People& people, const PeopleMaskOptions& mask) {
  return std::ranges::any_of(people, [&](const PersonBox& box) { return in_outline(box, px.x(), px.y(), mask); });
}

}  // namespace

PosePrior KeyframeOdometry::State::expected(const FrameTime& now) const {
  const SE3 step = motion_model.predict(last_time, now);
  PosePrior prior{.T_w_c = last_T * step, .information = {}};
  const double sigma_t = 0.5 * step.t.norm() + 0.02 / std::max(median_rho, 1e-6), sigma_r = 0.1;
  prior.information << Eigen::Vector3d::Constant(1 / (sigma_t * sigma_t)),
      Eigen::Vector3d::Constant(1 / (sigma_r * sigma_r));
  return prior;
}

// Points whose place is known well enough, by descriptor: one of every `every`, from `first` on. Returns how many were
// found.
int KeyframeOdometry::State::find_keypoints(const SE3& T, const Features& features, double radius_px, int every,
                                            int first) {
  constraints.clear();
  keypoint_of.assign(points.size(), {});
  int turn = first;
  for (std::size_t i = 0; i < points.size(); ++i) {
    TrackedPoint& point = points[i];
    point.now = TrackedPoint::Now::hidden;
    if (point.id == 0 || ++turn % every != 0) continue;
    const Eigen::Vector3d by_rho = T.R.transpose() * (point.ray.origin - T.t);
    const Eigen::Vector3d p = T.R.transpose() * point.ray.direction + point.ray.rho * by_rho;
    if (p.z() < 1e-2) continue;
    const double unsure = (pixel_jacobian(camera, p) * by_rho).norm() * point.ray.sigma_rho;
    if (unsure > 4 * options.mature_px) continue;
    const Eigen::Vector2d px = pixel_of(camera, p);
    const FoundKeypoint found = search.find(px, px, radius_px, point.descriptor.data());
    if (found.index < 0 || found.distance2 > options.max_distance2 || found.distance2 > 0.8f * found.second2) continue;
    keypoint_of[i] = found;
    const Keypoint& k = features.keypoints[found.index];
    constraints.push_back({.ray = point.ray, .pixel = {k.x, k.y}, .sigma_px = options.coarse_sigma_px});
  }
  return static_cast<int>(constraints.size());
}

// Where the camera must be for the points to be where keypoints look like them: near where it is expected, else where
// the frame before says, else wherever in the picture they are.
bool KeyframeOdometry::State::find_pose(const FrameTime& now, const FrameView& current, const FrameView& previous,
                                        const PosePrior& prior, SE3& T, PoseResult& out) {
  const auto agree = [&](int found, const RefinedPose& pose) {
    return pose.inliers >= options.min_tracked && pose.inliers > options.min_agreement * found;
  };
  // For a coarse pose a part of the points does; the other part's turn is in the next frame.
  const auto alive = std::ranges::count_if(points, [](const TrackedPoint& point) { return point.id != 0; });
  const int every = static_cast<int>(alive) / options.max_coarse + 1;
  int found =
      find_keypoints(prior.T_w_c, *current.features, options.search_px, every, static_cast<int>(now.index % every));
  const RefinedPose near =
      refine_pose(constraints, camera, prior, prior.T_w_c, {.loss_scale = 3, .widest = 8, .iterations = 4});
  T = near.T_w_c;
  if (agree(found, near)) return true;
  if (recover(now, current, previous, T, out)) return true;
  const PosePrior nothing{.T_w_c = prior.T_w_c, .information = 1e-2 * prior.information};
  found = find_keypoints(prior.T_w_c, *current.features, 2.0 * camera.width, 1, 0);
  const RefinedPose anywhere =
      refine_pose(constraints, camera, nothing, prior.T_w_c, {.loss_scale = 3, .widest = 128, .iterations = 5});
  T = anywhere.T_w_c;
  if (agree(found, anywhere)) return true;
  T = prior.T_w_c;
  return false;
}

// No pose from the map: the motion between the last two frames, its length from the motion model.
bool KeyframeOdometry::State::recover(const FrameTime& now, const FrameView& current, const FrameView& previous, SE3& T,
                                      PoseResult& out) {
  if (!previous.features || previous.features->size() != last_kept.size()) return false;
  match_nearest(*previous.features, *current.features, last_kept, out.kept, matches, nearest_scratch);
  pairs_of(matches, *previous.features, *current.features, out.pairs);
  refined.resize(out.pairs.size());
  if (previous.image) refine_subpixel(previous.image->view(), current.image->view(), out.pairs, refined);
  RelativeMotion motion = relative_motion(out.pairs, Random::for_frame(options.seed, now.index), out.is_inlier);
  if (!motion.found) return false;
  if (motion.quality != Quality::standing) {
    motion.T_p_c.t *= motion_model.predict(last_time, now).t.norm();
    T = last_T * motion.T_p_c;
  } else {
    T = last_T;
  }
  return true;
}

bool KeyframeOdometry::State::align_point(TrackedPoint& point, const Image& image, const Eigen::Vector2d& expected_px,
                                          double patch_scale, double max_shift_px) {
  AlignOptions align = options.align;
  align.max_shift_px = static_cast<float>(max_shift_px);
  const Aligned aligned = align_patch(point.patch, static_cast<float>(patch_scale), image.view(),
                                      static_cast<float>(expected_px.x()), static_cast<float>(expected_px.y()), align);
  if (!aligned.found) return false;
  point.px = {aligned.x, aligned.y};
  point.now = TrackedPoint::Now::found;
  return true;
}

// A point of unknown depth is somewhere on its epipolar line: the keypoint there that looks like it says where.
void KeyframeOdometry::State::align_along_line(TrackedPoint& point, const SE3& T, const FrameView& current) {
  const double nearest = point.ray.rho + 2 * point.ray.sigma_rho,
               farthest = std::max(0.0, point.ray.rho - 2 * point.ray.sigma_rho);
  RayPoint at = point.ray;
  const auto pixel_at = [&](double rho, Eigen::Vector2d& px) {
    at.rho = rho;
    const Eigen::Vector3d p = scaled_in_camera(at, T);
    if (p.z() < 1e-2) return false;
    px = pixel_of(camera, p);
    return true;
  };
  Eigen::Vector2d a, b;
  if (!pixel_at(farthest, a)) return;
  double high = nearest;
  while (!pixel_at(high, b) || (b - a).norm() > 100) high = farthest + (high - farthest) * 0.7;
  const FoundKeypoint found = search.find(a, b, 2.5, point.descriptor.data());
  if (found.index < 0 || found.distance2 > options.max_distance2 || found.distance2 > 0.7f * found.second2) return;
  const Keypoint& k = current.features->keypoints[found.index];
  const double along = (b - a).squaredNorm() > 1e-6
                           ? std::clamp((Eigen::Vector2d(k.x, k.y) - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0)
                           : 0.0;
  const RayPoint before = point.ray;
  point.ray.rho = farthest + along * (high - farthest);
  const double scale = point.patch_scale(T);
  point.ray = before;
  if (align_point(point, *current.image, {k.x, k.y}, scale, 2.5)) {
    std::copy_n(current.features->descriptor(found.index), Features::kDescriptorSize, point.descriptor.begin());
  }
}

void KeyframeOdometry::State::align_points(const SE3& T, const FrameView& current, const People& people) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    TrackedPoint& point = points[i];
    if (point.id == 0) continue;
    const Eigen::Vector3d by_rho = T.R.transpose() * (point.ray.origin - T.t);
    const Eigen::Vector3d p = T.R.transpose() * point.ray.direction + point.ray.rho * by_rho;
    if (p.z() < 1e-2) continue;
    const Eigen::Vector2d px = pixel_of(camera, p);
    if (px.x() < 0 || px.y() < 0 || px.x() >= camera.width || px.y() >= camera.height) continue;
    if (on_person(px.cast<float>(), people, options.people_mask)) continue;
    point.now = TrackedPoint::Now::searched;
    const double unsure = (pixel_jacobian(camera, p) * by_rho).norm() * point.ray.sigma_rho;
    if (unsure > options.mature_px) {
      align_along_line(point, T, current);
      continue;
    }
    Eigen::Vector2d from = px;
    if (keypoint_of[i].index >= 0) {
      const Keypoint& k = current.features->keypoints[keypoint_of[i].index];
      if ((Eigen::Vector2d(k.x, k.y) - px).norm() < 3 + unsure) {
        from = {k.x, k.y};
        std::copy_n(current.features->descriptor(keypoint_of[i].index), Features::kDescriptorSize,
                    point.descriptor.begin());
      }
    }
    align_point(point, *current.image, from, point.patch_scale(T), options.align.max_shift_px);
  }
}

RefinedPose KeyframeOdometry::State::pose_of_found(const PosePrior& prior, const SE3& from) {
  constexpr double kWidest = 16;  // 9.6 px: from less, a car ahead may hold the pose
  constraints.clear();
  constrained.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const TrackedPoint& point = points[i];
    if (point.id == 0 || point.now != TrackedPoint::Now::found) continue;
    constraints.push_back({.ray = point.ray, .pixel = point.px.cast<double>(), .sigma_px = options.sigma_px});
    constrained.push_back(static_cast<int>(i));
  }
  return refine_pose(constraints, camera, prior, from,
                     {.loss_scale = options.loss_scale, .widest = kWidest, .iterations = 5});
}

// A camera has inertia: the farther from where it was expected, the more points have to say so. (Where people filled
// the picture, 25 of them agreed on a leap to the side.) The longer no pose was found, the less sure is what was
// expected.
double KeyframeOdometry::State::points_needed(const PosePrior& prior, const SE3& T) const {
  const Eigen::Vector3d off = step_between(prior.T_w_c, T).head<3>();
  const double frames = 1 + lost;
  const double d2 = off.dot(prior.information.head<3>().cwiseProduct(off)) / (frames * frames);
  return std::min<double>(options.sure_tracked, options.min_tracked * (1 + d2));
}

// The images' points against those of the frame before, or of the one that the standstill began with.
bool KeyframeOdometry::State::standing(PoseResult& out) {
  pairs.clear();
  for (const TrackedPoint& point : points)
    if (point.id != 0 && point.now == TrackedPoint::Now::found && point.in_still)
      pairs.push_back({point.still_px.x(), point.still_px.y(), point.px.x(), point.px.y()});
  if (!stands_still(pairs, camera, options.motion.standstill, at_rest)) return false;
  out.T_w_c = published_T;  // to the bit, even where the map has moved
  stays = true;
  out.quality = Quality::standing;
  out.reason = PoseReason::standstill;
  return true;
}

}  // namespace pavo
