#include "stages/people/track_people.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

#include "stages/people/overlap.h"

namespace pavo {
namespace {

bool share(float value) {
  return value >= 0 && value <= 1;
}

bool finite(const PersonBox& b) {
  return std::isfinite(b.x) && std::isfinite(b.y) && std::isfinite(b.width) && std::isfinite(b.height) && b.width > 0 &&
         b.height > 0;
}

}  // namespace

TrackPeople::TrackPeople(const TrackPeopleOptions& options) : options_(options) {
  if (!(options_.match_overlap > 0 && options_.match_overlap <= 1))
    throw std::invalid_argument("people: match_overlap must be above 0 and at most 1");
  if (options_.confirm_hits < 1) throw std::invalid_argument("people: confirm_hits must be at least 1");
  if (options_.tentative_misses < 0 || options_.confirmed_misses < 0)
    throw std::invalid_argument("people: tentative_misses and confirmed_misses must not be negative");
  if (options_.longest_misses < options_.confirmed_misses)
    throw std::invalid_argument("people: longest_misses must not be less than confirmed_misses");
  if (!share(options_.position_gain) || !share(options_.velocity_gain))
    throw std::invalid_argument("people: position_gain and velocity_gain must be from 0 to 1");
}

void TrackPeople::operator()(const Detections& detections, People& people) {
  predict();
  match(detections);
  for (std::size_t t = 0; t < tracks_.size(); ++t)
    if (partner_of_track_[t] >= 0)
      correct(tracks_[t], detections[static_cast<std::size_t>(partner_of_track_[t])]);
    else
      ++tracks_[t].misses;
  bury_the_dead();
  for (std::size_t d = 0; d < detections.size(); ++d) {
    const PersonBox& b = detections[d];
    if (partner_of_detection_[d] < 0 && b.score >= options_.birth_score && finite(b))
      tracks_.push_back({{b.x + b.width / 2, b.y + b.height / 2, b.width, b.height}, {0, 0, 0, 0}, b.score, 1, 0});
  }
  report(people);
}

void TrackPeople::missed(People& people) {
  predict();
  for (Track& track : tracks_) ++track.misses;
  bury_the_dead();
  report(people);
}

void TrackPeople::predict() {
  for (Track& t : tracks_) {
    t.box.center_x += t.velocity.center_x;
    t.box.center_y += t.velocity.center_y;
    t.box.width += t.velocity.width;
    t.box.height += t.velocity.height;
  }
}

void TrackPeople::match(const Detections& detections) {
  partner_of_track_.assign(tracks_.size(), -1);
  partner_of_detection_.assign(detections.size(), -1);
  pairs_.clear();
  for (std::size_t t = 0; t < tracks_.size(); ++t) {
    const State& s = tracks_[t].box;
    const PersonBox predicted{s.center_x - s.width / 2, s.center_y - s.height / 2, s.width, s.height, 0};
    for (std::size_t d = 0; d < detections.size(); ++d) {
      const float overlap = finite(detections[d]) ? intersection_over_union(predicted, detections[d]) : 0.0f;
      if (overlap >= options_.match_overlap) pairs_.push_back({overlap, static_cast<int>(t), static_cast<int>(d)});
    }
  }
  std::sort(pairs_.begin(), pairs_.end(), [](const Pair& a, const Pair& b) {
    return std::tuple(-a.overlap, a.track, a.detection) < std::tuple(-b.overlap, b.track, b.detection);
  });
  for (const Pair& p : pairs_) {
    int& track = partner_of_track_[static_cast<std::size_t>(p.track)];
    int& detection = partner_of_detection_[static_cast<std::size_t>(p.detection)];
    if (track >= 0 || detection >= 0) continue;
    track = p.detection;
    detection = p.track;
  }
}

void TrackPeople::correct(Track& track, const PersonBox& b) const {
  const State seen{b.x + b.width / 2, b.y + b.height / 2, b.width, b.height};
  // The second detection is the first that says anything of the velocity, and it alone must set it.
  const float velocity_gain = track.hits == 1 ? options_.position_gain : options_.velocity_gain;
  // After m misses the innovation has gathered over m + 1 frames.
  const float per_frame = velocity_gain / static_cast<float>(track.misses + 1);
  for (float State::*part : {&State::center_x, &State::center_y, &State::width, &State::height}) {
    const float innovation = seen.*part - track.box.*part;
    track.box.*part += options_.position_gain * innovation;
    track.velocity.*part += per_frame * innovation;
  }
  track.score = b.score;
  ++track.hits;
  track.misses = 0;
}

void TrackPeople::bury_the_dead() {
  std::erase_if(tracks_, [&](const Track& t) {
    const int allowed = t.hits >= options_.confirm_hits
                            ? std::clamp(t.hits, options_.confirmed_misses, options_.longest_misses)
                            : options_.tentative_misses;
    return t.misses > allowed || !(t.box.width >= 1 && t.box.height >= 1);
  });
}

void TrackPeople::report(People& people) const {
  people.clear();
  for (const Track& t : tracks_)
    people.push_back(
        {t.box.center_x - t.box.width / 2, t.box.center_y - t.box.height / 2, t.box.width, t.box.height, t.score});
}

}  // namespace pavo
