// Frames to a folder that is a sequence at every moment, written by threads that never keep the camera waiting.
//
//   SequenceRecorder recorder("drive", {.camera = camera}, make_encoder);
//   while (camera.take(image, frame)) recorder.offer(image, frame.t_sensor_ns);
//   recorder.finish();
//
// EuRoC's layout:  DIR/mav0/cam0/data.csv (nanoseconds,file), data/NANOSECONDS.png, sensor.yaml
// KITTI's layout:  DIR/image_0/000000.png, times.txt (seconds), calib.txt (or camera.yaml for a camera with a lens)
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "drivers/trajectories/append_file.h"
#include "types/encoded_image.h"

namespace pavo {

enum class RecordLayout { euroc, kitti };

/// Fills `file` with the bytes of an image file, and returns the extension that it wants (".png"). Throws where the
/// frame cannot be encoded: that frame is counted as failed, and left out.
using EncodeFrame = std::function<std::string_view(const EncodedImage& frame, std::vector<std::uint8_t>& file)>;

struct RecorderOptions {
  RecordLayout layout = RecordLayout::euroc;
  std::vector<std::pair<std::string, std::string>> files;  ///< beside the frames' index: name, contents: calibrations
  int encoders = 2;                                        ///< threads
  int waiting = 32;                                        ///< frames that may wait for one
  bool wait_for_room = false;                              ///< a recorded source can wait; a camera cannot
};

struct RecordCounts {
  std::uint64_t offered = 0;  ///< = written + no_room + failed, at the end
  std::uint64_t written = 0;
  std::uint64_t no_room = 0;  ///< offered when all places were taken, or after the disk was full
  std::uint64_t failed = 0;   ///< could not be encoded
  std::uint64_t bytes = 0;    ///< of the image files
};

/// Each image is written under another name first and then renamed, and the index names only what is there (EuRoC), or
/// has a line for every number (KITTI): whenever the process is killed, the folder can be read up to there. A power
/// failure may cost the last half minute.
///
/// offer() is called by one thread; it swaps buffers, and does not block, encode or write. counts() and failed(): any
/// thread.
class SequenceRecorder {
 public:
  /// Makes the folder, which must be new or empty, and the threads; `make_encoder` is called once for each. Throws
  /// std::runtime_error of one line.
  SequenceRecorder(const std::filesystem::path& folder, const RecorderOptions& options,
                   const std::function<EncodeFrame()>& make_encoder);
  ~SequenceRecorder();  ///< without finish(), what is waiting is not written
  SequenceRecorder(const SequenceRecorder&) = delete;
  SequenceRecorder& operator=(const SequenceRecorder&) = delete;

  /// Takes the frame over: afterwards `frame` holds an older one's memory. Times increase, or std::runtime_error.
  /// False where it is not recorded: no room, or the recording has failed().
  bool offer(EncodedImage& frame, std::int64_t t_ns);
  /// Waits until everything is written and on the disk. Throws what ended the recording before its time.
  void finish();

  /// The disk is full, or the like: nothing more is written. What was written stays readable.
  bool failed() const;
  /// Why the first frame that failed did; "" where none did.
  std::string first_failure() const;
  RecordCounts counts() const;

 private:
  struct Job {
    EncodedImage frame;
    std::int64_t t_ns = 0;
    std::uint64_t number = 0;
  };

  bool is_euroc() const { return options_.layout == RecordLayout::euroc; }
  void work(const std::stop_token& stop, const EncodeFrame& encode);
  std::unique_ptr<Job> next_job(const std::stop_token& stop);
  void record(Job& job, const EncodeFrame& encode, std::vector<std::uint8_t>& file);
  void flush_index(std::uint64_t last);

  const RecorderOptions options_;
  std::filesystem::path folder_, images_;

  mutable std::mutex mutex_;  // guards all down to error_
  std::condition_variable_any changed_;
  std::deque<std::unique_ptr<Job>> waiting_;
  std::vector<std::unique_ptr<Job>> unused_;
  RecordCounts counts_;
  std::string first_failure_;
  /// The index's next lines, from that of frame next_line_ on; nothing: not known yet; "": this frame has none.
  std::deque<std::optional<std::string>> lines_;
  std::uint64_t next_line_ = 0;
  bool ended_ = false;
  std::exception_ptr error_;

  std::mutex index_mutex_;  // guards index_; mutex_ is not held while it is written, so that offer() waits for no disk
  AppendFile index_;

  std::int64_t last_ns_ = 0;  // the offering thread's own
  std::uint64_t next_number_ = 0;
  std::vector<std::jthread> threads_;  // last
};

}  // namespace pavo
