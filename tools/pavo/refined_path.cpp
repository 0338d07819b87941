#include "tools/pavo/refined_path.h"

#include <algorithm>

namespace pavo {

void RefinedPath::add(const SE3& T_w_c, bool is_keyframe) {
  if (is_keyframe) {
    links_.push_back({end_of_published(), last_keyframe_.inverse() * T_w_c});
    last_keyframe_ = T_w_c;
  }
  published_.push_back(T_w_c);
  if (published_.size() > kMostKept) final_until_ = std::max(final_until_, first_ + 1);
}

void RefinedPath::adjust(std::span<const KeyframePose> window) {
  if (window.empty()) return;
  const auto first_from = [&](std::int64_t frame) {
    return std::lower_bound(links_.begin(), links_.end(), frame,
                            [](const Link& l, std::int64_t f) { return l.frame < f; });
  };
  for (std::size_t i = 1; i < window.size(); ++i) {
    const auto link = first_from(window[i].frame);
    if (link == links_.end() || link->frame != window[i].frame) continue;
    const std::int64_t before = link == links_.begin() ? at_frame_ : (link - 1)->frame;
    if (before == window[i - 1].frame) link->T_before_this = window[i - 1].T_w_c.inverse() * window[i].T_w_c;
  }
  // The oldest keyframe hangs on none that is adjusted with it; what hangs on it moves with the next one's link only.
  if (const auto next = first_from(window.front().frame + 1); next != links_.end())
    final_until_ = std::max(final_until_, next->frame);
}

void RefinedPath::end() {
  final_until_ = end_of_published();
}

std::optional<SE3> RefinedPath::next_final() {
  if (published_.empty() || first_ >= final_until_) return std::nullopt;
  const SE3 published = published_.front();
  if (!links_.empty() && links_.front().frame == first_) {
    at_ = at_ * links_.front().T_before_this;
    was_ = published;
    at_frame_ = first_;
    links_.pop_front();
  }
  published_.pop_front();
  ++first_;
  return at_ * (was_.inverse() * published);
}

}  // namespace pavo
