// Which frames of a camera that watches a board are worth keeping.
#pragma once

#include <cstdint>
#include <vector>

#include "stages/calibration/board.h"

namespace pavo {

struct CollectOptions {
  double still_s = 0.4;        ///< so long the board has to hold still: no motion blur, no rolling shutter
  double still_share = 0.003;  ///< as far as it may move meanwhile (mean over its corners), of the image's diagonal
  double new_share = 0.05;     ///< as far from every view that was taken it has to be
};

enum class Seen {
  nothing,      ///< no board
  moving,       ///< it does not hold still yet
  known_place,  ///< as in a view that was taken
  taken,
};

/// Takes a view when the board holds still in a new place. One thread; in-order frames.
class CollectViews {
 public:
  CollectViews(int width, int height, const CollectOptions& options = {});

  /// `corners`: empty where no board was found. Times increase.
  Seen operator()(std::int64_t t_ns, const BoardCorners& corners);

  const std::vector<BoardCorners>& views() const { return views_; }

 private:
  bool is_new(const BoardCorners& corners) const;

  CollectOptions options_;
  double diagonal_px_;
  BoardCorners anchor_;  ///< where it stood when it last moved
  std::int64_t anchor_ns_ = 0;
  std::vector<BoardCorners> views_;
};

}  // namespace pavo
