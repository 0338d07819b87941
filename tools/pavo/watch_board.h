// A camera, or a recording of one, that watches somebody move a chessboard around.
#pragma once

#include <string>
#include <vector>

#include "stages/calibration/board.h"
#include "tools/pavo/frame_feed.h"

namespace pavo {

struct WatchedBoard {
  int width = 0, height = 0;
  std::vector<BoardCorners> views;
};

/// Takes a view whenever the board holds still in a new place, and says so in a line on stdout, with what is missing;
/// on a terminal it also says what the board is doing. Ends at the feed's end, or when `most_views` were taken. Throws
/// what the feed throws.
WatchedBoard watch_board(FrameFeed& feed, const Board& board, int most_views);

/// Opens the source, and ends at Ctrl-C, too. Throws std::runtime_error where it cannot be opened.
WatchedBoard watch_board(const std::string& source, const FeedOptions& options, const Board& board, int most_views);

}  // namespace pavo
