#include "stages/calibration/collect_views.h"

#include <algorithm>
#include <cmath>

namespace pavo {
namespace {

// Mean over the corners; the board may be seen from its other end (half a turn), which is another order of the same.
double distance(const BoardCorners& a, const BoardCorners& b) {
  double same = 0, turned = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    same += (a[i] - b[i]).norm();
    turned += (a[i] - b[b.size() - 1 - i]).norm();
  }
  return std::min(same, turned) / static_cast<double>(a.size());
}

}  // namespace

CollectViews::CollectViews(int width, int height, const CollectOptions& options)
    : options_(options), diagonal_px_(std::hypot(width, height)) {}

Seen CollectViews::operator()(std::int64_t t_ns, const BoardCorners& corners) {
  if (corners.empty()) {
    anchor_.clear();
    return Seen::nothing;
  }
  const bool moved =
      anchor_.size() != corners.size() || distance(anchor_, corners) > options_.still_share * diagonal_px_;
  if (moved) {
    anchor_ = corners;
    anchor_ns_ = t_ns;
  }
  if (!is_new(corners)) return Seen::known_place;
  if (static_cast<double>(t_ns - anchor_ns_) * 1e-9 < options_.still_s) return Seen::moving;
  views_.push_back(corners);
  return Seen::taken;
}

bool CollectViews::is_new(const BoardCorners& corners) const {
  return std::none_of(views_.begin(), views_.end(), [&](const BoardCorners& view) {
    return distance(view, corners) < options_.new_share * diagonal_px_;
  });
}

}  // namespace pavo
