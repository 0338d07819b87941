// The path as the map saw it in the end: what adjusting keyframes changed after their poses had been published.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>

#include "stages/map/map_messages.h"
#include "types/pose.h"

namespace pavo {

/// A chain from keyframe to keyframe: each link is what the last adjustment that held both said, and the frames between
/// hang on the keyframe before them as they did when they were published. Links, and not positions: the map is scaled
/// about its newest keyframe, which moves what is behind it. What has left the map's window does not change any more,
/// and is given out; kept is what has not. One caller at a time.
class RefinedPath {
 public:
  /// So many frames are kept at most: of a camera that stands for hours, no keyframe comes.
  static constexpr std::size_t kMostKept = 20'000;

  /// The pose of the next frame of the source, as published.
  void add(const SE3& T_w_c, bool is_keyframe);
  /// Keyframes that were adjusted together, the oldest first. None is older than the oldest of the time before.
  void adjust(std::span<const KeyframePose> window);
  /// No adjustment comes any more: all is final.
  void end();
  /// The refined pose of the next frame that is final.
  std::optional<SE3> next_final();

 private:
  struct Link {
    std::int64_t frame;  ///< of the keyframe
    SE3 T_before_this;   ///< its pose in the frame of the keyframe before
  };
  std::int64_t end_of_published() const { return first_ + static_cast<std::int64_t>(published_.size()); }

  std::deque<SE3> published_;  ///< from frame `first_` on
  std::deque<Link> links_;     ///< of those
  std::int64_t first_ = 0;
  std::int64_t final_until_ = 0;  ///< this frame and those behind it may still change
  SE3 last_keyframe_;             ///< as published
  SE3 at_, was_;                  ///< the keyframe that frame `first_` hangs on: refined, and as published
  std::int64_t at_frame_ = -1;
};

}  // namespace pavo
