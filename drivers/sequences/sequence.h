// A recorded (or rendered) sequence of frames, whatever its layout on disk.
//
//   auto sequence = open_sequence("kitti/05", {});
//   EncodedImage image; FrameStamp stamp;
//   for (bool more = true; more;) {
//     try { if ((more = sequence->read(image, stamp))) use(image, stamp); }
//     catch (const FrameError& error) { count_failed(stamp, error); }
//   }
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "types/camera.h"
#include "types/encoded_image.h"
#include "types/pose.h"

namespace pavo {

/// This frame cannot be read (its file is gone, unreadable, empty); the frames behind it still can.
class FrameError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct SequenceInfo {
  std::string layout;  ///< "KITTI odometry", "KITTI raw", "EuRoC", "TUM RGB-D", "images", "video", "synthetic"
  std::string path;    ///< as it was given
  std::optional<Camera> camera;    ///< with width and height of the images; nothing: no calibration found, none given
  std::string calibration_source;  ///< the file (and entry) that `camera` came from; without it: what was looked for

  /// T_w_c of the frames that have ground truth, in the frame of the first of them; t_ns where the frames have times.
  std::optional<Trajectory> groundtruth;
  /// The frame (FrameStamp::index) of each pose of `groundtruth`, ascending. Truth may begin late, end early and have
  /// holes: it is interpolated between its samples, and never invented outside of them.
  std::vector<std::int64_t> groundtruth_frames;
  std::string groundtruth_source;  ///< the file, and how much it covers if not all; without truth: why there is none

  bool has_times = false;  ///< false: t_capture_ns is the frame's number, and nothing may be derived from it
  double rate_hz = 0;      ///< by the median of the times between frames, or the container's; 0: not known
  std::optional<std::int64_t> frame_count;  ///< of a video: what its container says, which may be wrong; or unknown
};

/// Which frame it is and when it was taken.
struct FrameStamp {
  std::int64_t index = 0;         ///< of the frame in the source, from 0
  std::int64_t t_capture_ns = 0;  ///< the source's own time
  std::string name;               ///< "000042.jpg": for messages; keeps its capacity
};

/// Called by one thread, but for what says otherwise. read() blocks for the file system only.
class Sequence {
 public:
  virtual ~Sequence() = default;
  virtual const SequenceInfo& info() const = 0;
  /// The stamp of the frame that read() would deliver, without reading it; nothing at the end.
  virtual std::optional<FrameStamp> peek() = 0;
  /// Reads the next frame's bytes into `image` (which keeps its capacity) and its stamp; false at the end.
  /// Throws FrameError where this frame cannot be read, with `stamp` filled: the next call goes on with the next frame.
  virtual bool read(EncodedImage& image, FrameStamp& stamp) = 0;
  /// Passes the next frame by without reading it; false at the end.
  virtual bool skip() = 0;
  /// How many frames so far had no time, or one that did not increase, and were given one. Any thread.
  virtual std::int64_t times_replaced() const { return 0; }
};

struct SequenceOptions {
  std::string calibration;  ///< a file that takes precedence over the sequence's own; "" = the sequence's own
  /// A file that takes precedence (KITTI: a line per frame; TUM: by time; both of the camera; or EuRoC's data.csv, of
  /// the body); "none": no ground truth; "" = the sequence's own.
  std::string groundtruth;
  double rate_hz = 0;  ///< gives times (frame / rate_hz) to a source without any; 0 = none
};

/// What `source` is, from its contents: one of SequenceInfo::layout. Throws std::runtime_error with one line: what was
/// looked for and not found.
std::string recognise_layout(const std::string& source);

/// Opens a directory of a known layout (also by its image_0 ... image_3, image_00 ... image_03, mav0 or cam0 inside),
/// or a video file. All of it is checked here but the images themselves: index files, times, calibration, ground truth.
/// Throws std::runtime_error with one line: what was looked for and not found, or which file is malformed where.
std::unique_ptr<Sequence> open_sequence(const std::string& source, const SequenceOptions& options = {});

}  // namespace pavo
