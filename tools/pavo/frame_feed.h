// Frames one after the other, from a camera or a sequence: for the commands that need no pipeline.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "drivers/v4l2/system_calls.h"
#include "types/camera.h"
#include "types/encoded_image.h"

namespace pavo {

struct FeedOptions {
  bool newest = false;      ///< a camera's newest frame, the older ones go by; else every frame
  bool paced = false;       ///< a sequence's frames at their own times, as a camera would give them
  std::string calibration;  ///< a file; "": the sequence's own
  double rate_hz = 0;       ///< of a camera; gives times to a sequence without any
  // --- of a camera
  std::string config_file;  ///< its [device]; what follows is over that
  std::string size;         ///< "640x480"; "": the calibration's, else the one that the camera stands at
  std::string format;       ///< "YUYV"; "": the best
  std::string controls;     ///< "name=value, name=value"
};

/// `--calibration`, `--rate`, `--config`, `--size`, `--format`, `--controls`.
void add_feed_options(CLI::App& command, FeedOptions& options);

struct FeedCounts {
  std::uint64_t taken = 0;           ///< frames that next() gave
  std::uint64_t broken = 0;          ///< damaged by the driver's word, too short, unreadable: left out
  std::uint64_t lost = 0;            ///< by the driver, or while the camera was away
  std::uint64_t passed = 0;          ///< newer ones came (newest)
  std::uint64_t replaced_times = 0;  ///< of a video: those that were missing or did not increase
  std::string first_broken;          ///< why the first of them was
};

/// One reader. counts(): the same thread; interrupt(): any.
class FrameFeed {
 public:
  virtual ~FrameFeed() = default;
  virtual const std::optional<Camera>& camera() const = 0;  ///< where a calibration is there
  virtual std::string description() const = 0;              ///< for a person: what is read
  virtual std::optional<std::int64_t> frame_count() const { return std::nullopt; }
  /// The next frame that is whole, and when it was taken; swaps the buffer's memory. Blocks. False at the end, and
  /// when interrupted. Throws std::runtime_error where the source has ended before its time.
  virtual bool next(EncodedImage& image, std::int64_t& t_ns) = 0;
  virtual FeedCounts counts() const = 0;
  virtual void interrupt() = 0;
};

/// SOURCE is a device: it exists and is one, or its name says so.
bool is_camera(const std::string& source);

/// Throws std::runtime_error of one line, or UsageError where a sequence has no times and none were given.
std::unique_ptr<FrameFeed> open_feed(const std::string& source, const FeedOptions& options);

/// The same of a camera that answers through `system`, which outlives the feed.
std::unique_ptr<FrameFeed> open_camera_feed(v4l2::SystemCalls& system, const std::string& path,
                                            const FeedOptions& options);

}  // namespace pavo
