// `--draw`: the drawn frames, as pictures in a folder or as a film, off the hot path.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "engine/frame_info.h"
#include "tools/pavo/draw_frame.h"
#include "types/camera.h"

namespace pavo {

/// Draws and writes with a thread of its own. offer() is called by one thread at a time (the delivery); it copies the
/// frame and returns. When the drawing is kMostWaiting frames behind, offer() waits (every-frame) or passes the frame
/// by, counted (live).
class Movie {
 public:
  /// The pictures have the size of `camera`'s. `where`: a folder (made if it is not there; 000000.jpg, ...) or a file
  /// that ends in .mp4. Throws std::runtime_error, naming --draw, where it cannot be written.
  Movie(const std::string& where, const Camera& camera, double rate_hz, bool wait_for_drawing);
  ~Movie();  ///< ends the thread; without finish(), what is waiting is not drawn

  void offer(const Frame& frame, const FrameInfo& info, const Outcome& outcome);
  /// Waits until all is drawn and written. Throws what went wrong while drawing.
  void finish();
  std::int64_t passed_by() const { return passed_by_; }

 private:
  class Writer;
  static constexpr std::size_t kMostWaiting = 4;

  void draw(const std::stop_token& stop);

  std::unique_ptr<Writer> writer_;
  const int width_, height_;
  const bool wait_for_drawing_;
  std::int64_t passed_by_ = 0;

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<std::unique_ptr<FrameSnapshot>> waiting_;
  std::vector<std::unique_ptr<FrameSnapshot>> unused_;
  bool ended_ = false;
  std::exception_ptr error_;
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace pavo
