#include "stages/ground/ground_scale.h"

#include <algorithm>
#include <cmath>

namespace pavo {
namespace {

// The first row in which ground can lie that is near enough to be looked at, however the camera may be held.
int top_row(const Camera& camera, const GroundScaleOptions& options) {
  const double slope = std::tan(std::atan(options.align.farthest_slope) + options.filter.attitude.pitch_rad -
                                2 * options.filter.attitude_sigma);
  return static_cast<int>(camera.cy + camera.fy * slope) - 16;
}

// Of travel, in the camera's frame half way.
Eigen::Vector3d direction_of(const SE3& T_ref_cur) {
  const Eigen::Vector3d way = T_ref_cur.t.normalized();
  return (way + T_ref_cur.R.transpose() * way).normalized();
}

// People who go along look right at every scale that is small enough: what fits so widely, in bins of the votes, may be
// they. A small or slow picture of an open road is as wide, and right.
constexpr int kWidest = 10;

bool is_crowd(const People& people) {
  return people.size() >= 5;
}

// Where so many looks in a row do not fit, what is believed may be wrong.
constexpr int kDoubtful = 8;

}  // namespace

GroundScale::GroundScale(const Camera& rectified, const GroundScaleOptions& options)
    : options_(options), top_(top_row(rectified, options)), align_(rectified, options.align), filter_(options.filter) {}

GroundScale::Remembered& GroundScale::newest(std::int64_t frame, const ImageView& image) {
  Remembered& r = ring_[next_];
  next_ = (next_ + 1) % kRemembered;
  r.frame = frame;
  r.posed = false;
  r.image.assign(image, top_);
  return r;
}

void GroundScale::remember(std::int64_t frame, const ImageView& image) {
  newest(frame, image);
}

const GroundScale::Remembered* GroundScale::find(std::int64_t frame) const {
  for (const Remembered& r : ring_)
    if (r.frame == frame) return &r;
  return nullptr;
}

// The youngest frame that is far enough away, else the one that is farthest. While nobody knows how far that is: each
// age in turn.
const GroundScale::Remembered* GroundScale::choose_reference(const SE3& T_map_camera) const {
  const auto posed = [&](std::size_t age) -> const Remembered* {
    const Remembered& r = ring_[(next_ + kRemembered - 1 - age) % kRemembered];
    return r.frame >= 0 && r.posed ? &r : nullptr;
  };
  if (!filter_.known() || (unused_ > kDoubtful && !filter_.ways_are_strange())) return posed(1);
  const double wanted = options_.baseline * filter_.height_m() / filter_.metres_per_unit();
  const Remembered* best = nullptr;
  double farthest = 0;
  for (std::size_t age = 1; age < kRemembered; ++age) {
    const Remembered* r = posed(age);
    if (!r) continue;
    const double way = (r->T_map_camera.t - T_map_camera.t).norm();
    if (way > farthest) farthest = way, best = r;
    if (way >= wanted) break;
  }
  return best;
}

// The last frames vote on the unit. True once they are clear about another one than what is believed.
bool GroundScale::vote(const Remembered& current, const Remembered& reference, const SE3& T_ref_cur,
                       const People& people) {
  constexpr double kOther = 0.25;
  align_.vote(current.image, reference.image, T_ref_cur, filter_.attitude(), options_.filter.attitude_sigma,
              filter_.height_m(), people, votes_);
  const ScaleVotes::Peak peak = votes_.peak();
  const double scale = ScaleVotes::scale_of(peak.bin);
  const bool believed = filter_.known();
  const double clear = believed ? 1.8 : 1.4, enough = believed ? 0.8 : 0.4;
  if (peak.votes < enough || peak.votes < clear * peak.second) return false;
  if (is_crowd(people) && peak.width > kWidest) return false;
  if (believed && std::abs(std::log(scale / filter_.metres_per_unit())) < kOther) return false;
  filter_.assume(scale, options_.start_sigma);
  return true;
}

// The votes' bins are coarse: around the peak, the start from which most of the ground looks right.
GroundMeasurement GroundScale::best_of_starts(const Remembered& current, const Remembered& reference,
                                              const SE3& T_ref_cur, const People& people) {
  const double voted = filter_.metres_per_unit();
  GroundMeasurement best;
  double best_scale = voted;
  for (const double factor : {1.0, 0.87, 1.15, 0.75, 1.33}) {
    filter_.retarget(voted * factor);
    const GroundMeasurement m = align_(current.image, reference.image, T_ref_cur, filter_.expected(), people);
    const bool better = m.found != best.found ? m.found : m.agreed > best.agreed;
    if (better) best = m, best_scale = voted * factor;
  }
  filter_.retarget(best_scale);
  return best;
}

// A direction is as good as the way is long. While nobody knows how long: any way will do.
bool GroundScale::far_enough(const SE3& T_ref_cur) const {
  constexpr double kLeast = 0.25;  // in heights of the camera
  return !filter_.known() || T_ref_cur.t.norm() * filter_.metres_per_unit() >= kLeast * filter_.height_m();
}

// The less is known, the more of the ground has to agree.
bool GroundScale::trusted(const GroundMeasurement& m) const {
  constexpr double kSure = 0.08;
  constexpr int kMany = 8;
  return m.found && (filter_.sigma() < kSure || (m.agreed >= kMany && 3 * m.agreed >= m.asked));
}

GroundLook GroundScale::look(const Remembered& current, const Remembered& reference, const SE3& T_ref_cur,
                             const People& people) {
  GroundLook look;
  look.reference_frame = reference.frame;
  const bool is_way = far_enough(T_ref_cur);
  if (is_way) filter_.travelled(direction_of(T_ref_cur));
  // Where the motion is wrong, so is the plane that it shows. (Judged anew with each way: too short ones tell nothing.)
  const bool strange = is_way && filter_.ways_are_strange();
  const bool start = !filter_.known() || (unused_ > kDoubtful && !strange);
  if (start) votes_.fade(0.9);
  const bool found = start && vote(current, reference, T_ref_cur, people);
  if (!filter_.known()) {
    look.measurement.reason = GroundReason::no_agreement;
    return look;
  }
  look.measurement = found ? best_of_starts(current, reference, T_ref_cur, people)
                           : align_(current.image, reference.image, T_ref_cur, filter_.expected(), people);
  look.used = !strange && trusted(look.measurement) && filter_.update(look.measurement);
  if (found && !look.used) filter_.restart();
  unused_ = look.used ? 0 : unused_ + 1;
  if (look.used) votes_.clear();
  return look;
}

// In a crowd every bit of ground counts: the frames before the last one vote too.
void GroundScale::vote_with_others(const Remembered& current, const People& people) {
  for (const std::size_t age : {3, 2}) {
    const Remembered& r = ring_[(next_ + kRemembered - 1 - age) % kRemembered];
    if (r.frame < 0 || !r.posed) continue;
    align_.vote(current.image, r.image, r.T_map_camera.inverse() * current.T_map_camera, filter_.attitude(),
                options_.filter.attitude_sigma, filter_.height_m(), people, votes_);
  }
}

GroundLook GroundScale::observe(std::int64_t frame, const ImageView& image, const SE3& T_map_camera,
                                const People& people) {
  Remembered& current = newest(frame, image);
  current.T_map_camera = T_map_camera;
  current.posed = true;
  filter_.predict(options_.scale_walk);
  if (!filter_.known()) vote_with_others(current, people);
  const Remembered* reference = choose_reference(T_map_camera);
  if (!reference) return {};
  return look(current, *reference, reference->T_map_camera.inverse() * T_map_camera, people);
}

GroundLook GroundScale::step(std::int64_t frame, std::int64_t reference_frame, const SE3& T_reference_current,
                             double expected_m, double seconds, const People& people) {
  const double length = T_reference_current.t.norm();
  constexpr double kShortest_m = 1e-3;
  if (expected_m > kShortest_m && filter_.known()) {
    filter_.retarget(expected_m / length);
    filter_.predict(std::min(1.0, options_.acceleration * seconds * seconds / expected_m));
  } else {
    filter_.restart();
  }
  const Remembered *current = find(frame), *reference = find(reference_frame);
  if (!current || !reference || current == reference || !(length > 0)) return {};
  return look(*current, *reference, T_reference_current, people);
}

void GroundScale::rescale(double factor, const Eigen::Vector3d& fixed) {
  filter_.rescale(factor);
  for (Remembered& r : ring_) r.T_map_camera.t = fixed + factor * (r.T_map_camera.t - fixed);
}

void GroundScale::restart() {
  votes_.clear();
  filter_.restart();
  for (Remembered& r : ring_) r.posed = false;
}

}  // namespace pavo
