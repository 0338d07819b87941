#include "tools/pavo/watch_board.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>

#include "stages/calibration/collect_views.h"
#include "stages/calibration/coverage.h"
#include "stages/decode/decode.h"
#include "tools/pavo/signals.h"

namespace pavo {
namespace {

// "; next: the left edge of the image, and 3 more".
std::string next_of(const WatchedBoard& watched, const Board& board) {
  const auto missing = missing_views(coverage_of(watched.views, board, watched.width, watched.height));
  if (missing.empty()) return "; nothing is missing";
  const std::size_t others = missing.size() - 1;
  return "; next: " + missing.front() + (others > 0 ? fmt::format(", and {} more", others) : "");
}

// What to do next, on a terminal; it is drawn over itself.
class Advice {
 public:
  ~Advice() { clear(); }
  void clear() const {
    if (on_terminal_) fmt::print(stderr, "\r\033[K");
  }
  void show(Seen seen, const WatchedBoard& watched, const Board& board, int most_views) const {
    if (!on_terminal_) return;
    const char* doing = seen == Seen::nothing       ? "no board in sight"
                        : seen == Seen::moving      ? "hold it still"
                        : seen == Seen::known_place ? "seen from here; move on"
                                                    : "taken";
    fmt::print(stderr, "\r\033[K{}/{} views: {}{}", watched.views.size(), most_views, doing, next_of(watched, board));
    std::fflush(stderr);
  }

 private:
  bool on_terminal_ = isatty(STDERR_FILENO);
};

std::string place_of(const BoardCorners& view) {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : view) centre += p / static_cast<double>(view.size());
  return fmt::format("around ({:.0f}, {:.0f})", centre.x(), centre.y());
}

}  // namespace

WatchedBoard watch_board(FrameFeed& feed, const Board& board, int most_views) {
  WatchedBoard watched;
  std::unique_ptr<CollectViews> collect;
  const Decode decode;
  Decode::Scratch scratch;
  EncodedImage encoded;
  Image image;
  const Advice advice;
  std::int64_t t_ns = 0;
  while (static_cast<int>(watched.views.size()) < most_views && feed.next(encoded, t_ns)) {
    try {
      decode(encoded, image, scratch);
    } catch (const std::runtime_error&) {
      continue;  // a damaged frame is no view
    }
    if (!collect)
      collect = std::make_unique<CollectViews>(watched.width = image.width(), watched.height = image.height());
    const Seen seen = (*collect)(t_ns, find_board(image.view(), board, BoardSearch::quick));
    if (seen == Seen::taken) {
      watched.views = collect->views();
      advice.clear();
      fmt::print("view {} taken, {}{}\n", watched.views.size(), place_of(watched.views.back()),
                 next_of(watched, board));
      std::fflush(stdout);
    }
    advice.show(seen, watched, board, most_views);
  }
  return watched;
}

WatchedBoard watch_board(const std::string& source, const FeedOptions& options, const Board& board, int most_views) {
  std::atomic<FrameFeed*> running{nullptr};
  std::atomic<bool> interrupted{false};
  const Signals signals([&] {
    interrupted = true;
    if (FrameFeed* feed = running.load()) feed->interrupt();
  });
  const std::unique_ptr<FrameFeed> feed = open_feed(source, options);
  running = feed.get();
  if (interrupted) feed->interrupt();
  WatchedBoard watched = watch_board(*feed, board, most_views);
  running = nullptr;
  return watched;
}

}  // namespace pavo
