// A camera as the world sees it: frames, for days, whatever happens to the cable.
//
//   v4l2::Kernel kernel;
//   v4l2::LiveCamera camera(kernel, "/dev/video0", {.format = {.size = {640, 480}}}, log_line);
//   EncodedImage image;
//   v4l2::CameraFrame frame;
//   while (camera.wait())
//     try {
//       if (camera.take(image, frame)) use(image, frame);
//     } catch (const v4l2::FrameFault& fault) {
//       count_failed(frame, fault);
//     }
//
// A thread of its own takes filled buffers out of the driver as soon as they are there, so that the driver never
// starves while somebody computes. It is also the one who notices that the camera is gone:
//
//   streaming --(no frame for too long, EIO, ENODEV)--> away: closed, unmapped
//       ^                                                 |
//       +------(opened, format agreed upon anew)----------+
//
// Away, it tries at once, then with pauses of 50 ms that grow to 500 ms, and whenever something happens in /dev
// (inotify; no udev needed).
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "drivers/v4l2/camera_session.h"
#include "types/encoded_image.h"

namespace pavo::v4l2 {

struct CameraOptions {
  FormatRequest format;
  int buffers = 4;  ///< that the driver fills; it may give fewer
  std::vector<ControlValue> controls;
  /// false: the newest frame is kept, an older one goes back to the driver unread (`stale`). true, for recordings:
  /// every frame in its order; who is slow makes the driver lose frames, which tells in `lost_before`.
  bool every_frame = false;
  std::int64_t patience_ns = 2'000'000'000;  ///< without a frame for so long (10 periods at least) the camera hangs
  std::int64_t give_up_ns = 0;               ///< after so long away it is over; 0: never
};

/// What is known of one frame, on CLOCK_MONOTONIC.
struct CameraFrame {
  std::uint32_t sequence = 0;  ///< the driver's count; it may start again after an outage
  std::int64_t t_sensor_ns =
      0;  ///< the driver's stamp where it can be believed (FrameClock): always later than the last
  std::int64_t t_dequeue_ns = 0;  ///< when it was taken out of the driver
  bool at_start = false;          ///< the stamp is of the exposure's start; else of the last byte's arrival
  std::uint64_t lost_before = 0;  ///< frames that the driver lost since the one taken before; after an outage, those
                                  ///< that would have come meanwhile, 1 at least
  bool after_outage = false;
};

/// This one frame is broken: damaged by the driver's own word, or too short. The next one may be good.
class FrameFault : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct CameraReport {
  DeviceName name;
  StreamFormat format;  ///< the present one
  int buffers = 0;
  bool stamps_at_start = false;  ///< of the last frame: its stamp is of the exposure's start, else of its last byte
  bool streaming = false;        ///< false: it is away, and waited for
  std::uint64_t dequeued = 0;    ///< = taken + stale + what lies ready
  std::uint64_t taken = 0;       ///< damaged and short ones included
  std::uint64_t stale = 0;       ///< went back unread, since a newer one came
  std::uint64_t lost = 0;        ///< by holes in the driver's count
  std::uint64_t damaged = 0;     ///< V4L2_BUF_FLAG_ERROR
  std::uint64_t too_short = 0;
  StampCounts replaced_stamps;
  struct Outages {
    std::uint64_t hung = 0, failed = 0, unplugged = 0;
    std::uint64_t lost = 0;              ///< frames that would have come meanwhile
    std::int64_t away_ns = 0;            ///< all together, from the fault to the first frame
    std::int64_t longest_return_ns = 0;  ///< from the node's return (else the fault) to the first frame
    std::uint64_t all() const { return hung + failed + unplugged; }
  } outages;
};

class LiveCamera {
 public:
  /// Opens the camera and starts it. `tell` is called by the capture thread, a line for each change of its state.
  /// Throws DeviceError. A driver that stumbles at first (EIO, EINVAL) is asked three times.
  LiveCamera(SystemCalls& system, std::string path, CameraOptions options,
             std::function<void(const std::string&)> tell = {});
  ~LiveCamera();
  LiveCamera(const LiveCamera&) = delete;
  LiveCamera& operator=(const LiveCamera&) = delete;

  const DeviceName& name() const { return name_; }
  const StreamFormat& format() const { return format_; }  ///< the first one; its size never changes

  // --- the reader: one thread
  /// A frame lies ready, or the end has come. Does not block.
  bool ready() const { return ready_.load(); }
  /// Blocks until ready(). False at the end: interrupted, or given up (then rethrow_error() throws).
  bool wait();
  /// Copies a frame that lies ready and gives its buffer back. False where none does. Throws FrameFault, with `frame`
  /// filled. Blocks for the copy only; `image` keeps its capacity.
  bool take(EncodedImage& image, CameraFrame& frame);
  /// Called (by the capture thread, under a lock: no calls back) whenever a frame comes, and at the end.
  void on_ready(std::function<void()> wake);
  /// No frame will come any more, nor lies ready.
  bool ended() const { return ended_.load() && nothing_held(); }
  /// Ends the capture; returns how many frames lie ready, and can still be taken. Blocks until its thread is through.
  std::uint64_t stop();
  void rethrow_error() const;

  // --- anybody, any time
  /// No more frames: wait() returns false. Does not block.
  void interrupt();
  CameraReport report() const;
  std::uint64_t stale() const;  ///< the report's, without making one

 private:
  enum class FaultKind : std::uint8_t { none, hung, failed, unplugged };
  struct Fault {
    FaultKind kind = FaultKind::none;
    std::string what;
  };
  struct Held {
    FilledBuffer buffer;
    CameraFrame frame;
  };

  bool nothing_held() const;
  void open_first();
  void capture();
  Fault stream_until_fault();
  bool has_room() const;
  int take_in();
  bool is_too_short(const FilledBuffer& buffer) const;
  CameraFrame judge(const FilledBuffer& buffer);
  void hold(const FilledBuffer& buffer, const CameraFrame& frame);
  void close_session(const Fault& fault);
  void recover(const Fault& fault);
  bool try_to_open(std::string& problem, int& code);
  void tell(const std::string& what) const;
  std::int64_t patience_ns() const;
  Fault fault_of(int result) const;

  SystemCalls& system_;
  const std::string path_;
  CameraOptions options_;
  const std::function<void(const std::string&)> tell_;
  DeviceName name_;
  StreamFormat format_;

  mutable std::mutex mutex_;  // guards all down to `report_`; held while a frame is copied, never while waiting
  std::condition_variable changed_;
  std::function<void()> wake_;
  std::unique_ptr<CameraSession> session_;
  std::vector<Held> held_;         // the oldest first
  std::uint64_t lost_unread_ = 0;  // before what is held, of frames that nobody read
  bool outage_unread_ = false;
  CameraReport report_;

  FrameClock clock_;  // the capture thread's own
  SequenceCheck sequence_;
  bool first_of_session_ = true, after_outage_ = false;
  std::int64_t last_sensor_ns_ = 0, t_fault_ns_ = 0, t_back_ns_ = 0;
  std::string news_;          // to be told when the lock is free
  std::exception_ptr error_;  // written before ended_

  std::atomic<bool> ready_{false}, ended_{false}, stop_{false};
  Kernel kernel_;
  Descriptor wake_fd_;   // an eventfd: the word to the capture thread
  std::jthread thread_;  // last
};

}  // namespace pavo::v4l2
