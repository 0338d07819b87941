#include "stages/pose/odometry.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "stages/matches/klt.h"
#include "stages/matches/nearest.h"
#include "stages/matches/refine_subpixel.h"

namespace pavo {
namespace {

// A frame that another one can be matched against.
struct Reference {
  bool usable = false;     // it has enough features
  bool estimated = false;  // its pose was seen, not coasted
  FrameTime time;
  FrameTime still_until;  // the last frame that is known to have the same pose
  int matches = 0;        // of that frame, when the standstill began
  SE3 T_w_c;
  std::vector<std::uint8_t> kept;      // one per keypoint: 0 = on a person
  std::vector<std::uint8_t> doubtful;  // 1 = of these, only on those who may be none
};

void copy(const Features& from, Features& to) {
  to.reserve(from.size());
  to.keypoints = from.keypoints;
  if (from.descriptors)
    std::memcpy(to.descriptors.get(), from.descriptors.get(), from.size() * Features::kDescriptorSize * sizeof(float));
}

void copy(const Image& from, Image& to) {
  to.resize(from.width(), from.height());
  for (int y = 0; y < from.height(); ++y) std::memcpy(to.row(y), from.row(y), static_cast<std::size_t>(from.width()));
}

// Thousands of products of rotations leave SO(3) by rounding: back to it.
Eigen::Matrix3d orthonormal(const Eigen::Matrix3d& R) {
  return Eigen::Quaterniond(R).normalized().toRotationMatrix();
}

}  // namespace

struct Odometry::State {
  State(const Camera& rectified, const OdometryOptions& how, std::shared_ptr<const StepLength> length)
      : options(how),
        step_length(std::move(length)),
        match_nearest({.ratio = how.match_ratio, .spread = how.spread}),
        relative_motion(rectified, how.motion),
        camera(rectified) {
    if (how.ground) ground.emplace(rectified, *how.ground);
    if (!step_length) throw std::invalid_argument("odometry: no step length given");
  }

  void begin(const FrameTime& now, PoseResult& out);
  void drop_features_on_people(const Features& features, const People& people, PoseResult& out);
  bool enough_features(PoseResult& out) const;
  bool find_pose(const FrameTime& now, const FrameView& current, const FrameView& previous, PoseResult& out);
  void match(const Reference& from, const FrameView& reference, const FrameView& current, PoseResult& out);
  void refine(const Image& reference, const Image& current, PointPairs& pairs);
  bool track(const Reference& from, const FrameView& reference, const FrameTime& now, const FrameView& current,
             PoseResult& out);
  void match_descriptors(const Reference& from, const FrameView& reference, const FrameView& current, PoseResult& out);
  void put_back_street(const FrameView& reference, const FrameView& current, RelativeMotion& motion, PoseResult& out);
  void apply_scale(const Reference& from, const FrameTime& now, RelativeMotion& motion);
  double measured_on_ground(const Reference& from, const FrameTime& now, const SE3& T_p_c, double expected_m);
  void coast(const FrameTime& now, PoseResult& out);
  void choose_reference(const FrameTime& now, const FrameView& previous, bool estimated, const PoseResult& out);
  void keep_last(const FrameView& previous);
  void end(const FrameTime& now, bool usable, bool estimated, const PoseResult& out);

  OdometryOptions options;
  std::shared_ptr<const StepLength> step_length;
  MatchNearest match_nearest;
  TrackKlt track_klt;
  RefineSubpixel refine_subpixel;
  RelativeMotionEstimator relative_motion;
  Camera camera;
  MotionModel motion_model;
  std::optional<GroundScale> ground;
  const People* people_now = nullptr;

  bool started = false;
  Reference last;  // the frame of the call before
  // An earlier frame that is the better one to match against, and a copy of what its slot held: the last estimated one,
  // while `last` is not; or the one that a standstill began with, so that what is too slow to be seen between two
  // frames still is seen, and nothing of it is lost.
  Reference good;
  Features good_features;
  Image good_image;
  bool good_has_image = false;

  Matches matches;
  MatchNearest::Scratch nearest_scratch;
  People believed;
  std::vector<std::uint8_t> doubtful, matched_before, matched_now;
  Matches doubtful_matches;
  PointPairs on_people;  // that are doubtful
  Tracks tracks;
  TrackKlt::Scratch klt_scratch;
  std::vector<std::uint8_t> refined;
};

void Odometry::State::begin(const FrameTime& now, PoseResult& out) {
  out.begin(last.T_w_c);
  doubtful.clear();
  if (now.index - good.still_until.index > options.max_reference_age) good.usable = false;
}

void Odometry::State::drop_features_on_people(const Features& features, const People& people, PoseResult& out) {
  out.keypoints = static_cast<int>(features.size());
  out.kept.resize(features.size());
  out.dropped_on_people =
      static_cast<int>(features_on_people(features.keypoints, people, out.kept, options.people_mask));
  doubtful.assign(features.size(), 0);
  if (!options.put_back || out.dropped_on_people == 0) return;
  believed.clear();
  for (const PersonBox& person : people)
    if (person.score >= options.street.believed) believed.push_back(person);
  features_on_people(features.keypoints, believed, doubtful, options.people_mask);
  std::ranges::transform(doubtful, out.kept, doubtful.begin(),
                         [](std::uint8_t beside, std::uint8_t kept) { return std::uint8_t{beside && !kept}; });
}

bool Odometry::State::enough_features(PoseResult& out) const {
  if (out.keypoints - out.dropped_on_people >= options.motion.min_matches) return true;
  out.reason =
      out.keypoints >= options.motion.min_matches ? PoseReason::too_few_after_people : PoseReason::too_few_keypoints;
  return false;
}

// Against the last estimated frame, else against the one before this (whose pose was coasted then). The first frame
// with features is where the path begins; failed ones before it leave the camera at the origin.
bool Odometry::State::find_pose(const FrameTime& now, const FrameView& current, const FrameView& previous,
                                PoseResult& out) {
  if (!started) {
    started = true;
    out.quality = Quality::tracked;
    out.reason = PoseReason::first_frame;
    return true;
  }
  out.reason = PoseReason::no_reference;
  const FrameView copied{&good_features, good_has_image ? &good_image : nullptr};
  if (good.usable && track(good, copied, now, current, out)) {
    // A standstill's first frame that hardly anything is left of (the light, the traffic) is no witness of motion.
    if (out.quality == Quality::standing || 2 * out.matches >= good.matches) return true;
  }
  return last.usable && previous.features && track(last, previous, now, current, out);
}

// What is kept and what is doubtful at once, so that each finds its own partner; then the two are told apart.
void Odometry::State::match_descriptors(const Reference& from, const FrameView& reference, const FrameView& current,
                                        PoseResult& out) {
  const auto either = [](const auto& kept, const auto& doubt, std::vector<std::uint8_t>& matched) {
    matched.resize(kept.size());
    std::ranges::transform(kept, doubt, matched.begin(), std::bit_or<std::uint8_t>());
  };
  either(from.kept, from.doubtful, matched_before);
  either(out.kept, doubtful, matched_now);
  // How many are put back hangs on the motion, too: room for as many as there can ever be.
  const std::size_t most = std::min(matched_before.size(), matched_now.size());
  for (PointPairs* pairs : {&out.pairs, &on_people}) pairs->reserve(most);
  doubtful_matches.reserve(most);
  out.is_inlier.reserve(most);
  relative_motion.reserve(most);
  match_nearest(*reference.features, *current.features, matched_before, matched_now, matches, nearest_scratch);
  const auto kept = [&](const Match& m) {
    return from.kept[static_cast<std::size_t>(m.previous)] && out.kept[static_cast<std::size_t>(m.current)];
  };
  doubtful_matches.clear();
  std::ranges::remove_copy_if(matches, std::back_inserter(doubtful_matches), kept);
  std::erase_if(matches, [&](const Match& m) { return !kept(m); });
  pairs_of(matches, *reference.features, *current.features, out.pairs);
  pairs_of(doubtful_matches, *reference.features, *current.features, on_people);
}

void Odometry::State::match(const Reference& from, const FrameView& reference, const FrameView& current,
                            PoseResult& out) {
  on_people.clear();
  if (options.tracker == Tracker::klt) {
    if (!reference.image || !current.image) throw std::invalid_argument("odometry: KLT needs both images");
    track_klt(*reference.image, *current.image, reference.features->keypoints, from.kept, tracks, klt_scratch);
    out.pairs.assign(tracks.pairs.begin(), tracks.pairs.end());
  } else {
    match_descriptors(from, reference, current, out);
    if (options.refine_subpixel && reference.image && current.image) {
      refine(*reference.image, *current.image, out.pairs);
    }
  }
  out.matches = static_cast<int>(out.pairs.size());
}

// Every pair for itself, so that others may take some.
void Odometry::State::refine(const Image& reference, const Image& current, PointPairs& pairs) {
  constexpr std::size_t kAtATime = 128;
  refined.resize(pairs.size());
  const auto turn = [&](int, int k) {
    const std::size_t first = static_cast<std::size_t>(k) * kAtATime, n = std::min(kAtATime, pairs.size() - first);
    refine_subpixel(reference.view(), current.view(), std::span(pairs).subspan(first, n),
                    std::span(refined).subspan(first, n));
  };
  spread_or_not(options.spread, static_cast<int>((pairs.size() + kAtATime - 1) / kAtATime), turn);
}

// Match, estimate, scale, chain. False, with the reason, where nothing could be estimated.
bool Odometry::State::track(const Reference& from, const FrameView& reference, const FrameTime& now,
                            const FrameView& current, PoseResult& out) {
  if (reference.features->size() != from.kept.size())
    throw std::invalid_argument("odometry: the previous frame's features are not those of the call before");
  out.reference_frame = from.time.index;
  match(from, reference, current, out);
  RelativeMotion motion = relative_motion(out.pairs, Random::for_frame(options.seed, now.index), out.is_inlier);
  out.inliers = motion.inliers;
  out.reason = motion.reason;
  if (!motion.found) return false;
  put_back_street(reference, current, motion, out);
  out.quality = motion.quality;
  if (motion.quality == Quality::standing) {
    out.T_w_c = from.T_w_c;
    motion_model.observe(SE3{}, from.still_until, now);
    return true;
  }
  apply_scale(from, now, motion);
  out.step_m = motion.T_p_c.t.norm();
  out.T_w_c = from.T_w_c * motion.T_p_c;
  out.T_w_c.R = orthonormal(out.T_w_c.R);
  motion_model.observe(motion.T_p_c, from.still_until, now);
  return true;
}

// Those on people who may be none, as far as they move with the street.
void Odometry::State::put_back_street(const FrameView& reference, const FrameView& current, RelativeMotion& motion,
                                      PoseResult& out) {
  if (on_people.empty() || motion.reason != PoseReason::none) return;
  if (options.refine_subpixel && reference.image && current.image) refine(*reference.image, *current.image, on_people);
  put_back(on_people, *people_now, options.people_mask, camera, motion.T_p_c.inverse(), options.street, out.pairs);
  if (static_cast<std::size_t>(out.matches) == out.pairs.size()) return;
  out.matches = static_cast<int>(out.pairs.size());
  relative_motion.refine_again(out.pairs, motion, out.is_inlier);
  out.inliers = motion.inliers;
}

// NaN until the ground was seen.
double Odometry::State::measured_on_ground(const Reference& from, const FrameTime& now, const SE3& T_p_c,
                                           double expected_m) {
  const double seconds = static_cast<double>(now.t_ns - from.still_until.t_ns) * 1e-9;
  constexpr double kUsual_s = 0.1;  // where the frames have no times
  ground->step(now.index, from.time.index, T_p_c, expected_m, seconds > 0 ? seconds : kUsual_s, *people_now);
  return ground->known() ? ground->metres_per_unit() : std::numeric_limits<double>::quiet_NaN();
}

void Odometry::State::apply_scale(const Reference& from, const FrameTime& now, RelativeMotion& motion) {
  const Eigen::Vector3d expected = motion_model.predict(from.still_until, now).t;
  double metres = step_length->metres(
      {from.time.index, from.still_until.index, now.index, from.time.t_ns, from.still_until.t_ns, now.t_ns});
  if (ground && motion.reason != PoseReason::rotation_only) {
    const double seen = measured_on_ground(from, now, motion.T_p_c, expected.norm());
    if (std::isfinite(seen)) metres = seen;
  }
  if (!std::isfinite(metres) || metres < 0) metres = expected.norm();
  if (motion.reason == PoseReason::rotation_only) {
    // Without a unit, a step that nothing in the image shows is none.
    if (!step_length->metric()) metres = 0;
    if (expected.norm() > 0) motion.T_p_c.t = expected.normalized();
  }
  motion.T_p_c.t *= metres;
}

void Odometry::State::coast(const FrameTime& now, PoseResult& out) {
  const SE3 step = motion_model.predict(last.time, now);
  out.quality = Quality::coasting;
  if (!started || (step.R.isIdentity(0) && step.t.isZero(0))) return;  // at rest: to the bit
  out.T_w_c = last.T_w_c * step;
  out.T_w_c.R = orthonormal(out.T_w_c.R);
  out.step_m = step.t.norm();
}

// What the next frame is matched against beside this one, if anything.
void Odometry::State::choose_reference(const FrameTime& now, const FrameView& previous, bool estimated,
                                       const PoseResult& out) {
  if (estimated && out.quality == Quality::standing) {
    const bool begins = out.reference_frame != good.time.index || !good.usable;
    if (begins) {
      keep_last(previous);
      good.matches = out.matches;
    }
    good.still_until = now;
  } else if (estimated) {
    good.usable = false;
  } else if (!good.usable) {
    keep_last(previous);
    good.matches = 0;
  }
}

// The slot of the previous frame is about to go: take over what is needed to match against it.
void Odometry::State::keep_last(const FrameView& previous) {
  if (!last.estimated || !previous.features || previous.features->size() != last.kept.size()) return;
  std::swap(good, last);
  last.time = good.time;
  last.T_w_c = good.T_w_c;
  copy(*previous.features, good_features);
  good_has_image = previous.image != nullptr;
  if (previous.image) copy(*previous.image, good_image);
}

void Odometry::State::end(const FrameTime& now, bool usable, bool estimated, const PoseResult& out) {
  last.usable = usable;
  last.estimated = estimated;
  last.time = last.still_until = now;
  last.T_w_c = out.T_w_c;
  last.kept.assign(out.kept.begin(), out.kept.end());
  last.doubtful.assign(doubtful.begin(), doubtful.end());
}

Odometry::Odometry(const Camera& camera, const OdometryOptions& options, std::shared_ptr<const StepLength> step_length)
    : state_(std::make_unique<State>(camera, options, std::move(step_length))) {}
Odometry::~Odometry() = default;
Odometry::Odometry(Odometry&&) noexcept = default;
Odometry& Odometry::operator=(Odometry&&) noexcept = default;

void Odometry::operator()(const FrameTime& now, const FrameView& current, const FrameView& previous,
                          const People& people, PoseResult& out) {
  State& s = *state_;
  if (!current.features) throw std::invalid_argument("odometry: the current frame has no features; call missed()");
  s.begin(now, out);
  s.people_now = &people;
  if (s.ground && current.image) s.ground->remember(now.index, current.image->view());
  s.drop_features_on_people(*current.features, people, out);
  const bool usable = s.enough_features(out);
  const bool estimated = usable && s.find_pose(now, current, previous, out);
  if (!estimated) s.coast(now, out);
  if (s.ground && s.ground->known()) out.attitude = s.ground->attitude();
  s.choose_reference(now, previous, estimated, out);
  s.end(now, usable, estimated, out);
}

void Odometry::missed(const FrameTime& now, const FrameView& previous, PoseResult& out) {
  State& s = *state_;
  s.begin(now, out);
  out.reason = PoseReason::missed;
  s.coast(now, out);
  s.choose_reference(now, previous, false, out);
  s.end(now, false, false, out);
}

}  // namespace pavo
