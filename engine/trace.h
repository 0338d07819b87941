// What every thread did when, as a file for ui.perfetto.dev (or chrome://tracing).
#pragma once

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "engine/event_count.h"
#include "engine/event_ring.h"

namespace pavo {

struct TraceEvent {
  enum class Kind : std::uint8_t {
    stage,    ///< a node's call for a frame, from t_start_ns to t_end_ns
    failed,   ///< the same; it threw
    missed,   ///< the same; the frame had failed before
    late,     ///< the same; the fallback for a frame that is over its budget
    dropped,  ///< a frame was dropped at t_start_ns; `node` is the reason
  };
  std::int64_t t_start_ns = 0, t_end_ns = 0;
  std::int64_t wait_ns = 0;  ///< from ready to started
  std::uint64_t sequence = 0;
  std::uint32_t node = 0;
  std::uint16_t in_flight = 0;  ///< of the source: frames in the ring, with this one
  Kind kind = Kind::stage;
};

/// Chrome's Trace Event Format (JSON): a row for each thread, a slice for each stage's call, flow arrows that follow a
/// frame from thread to thread, an instant for each drop, a counter of the frames in flight. Memory is bounded: a ring
/// of 4096 events for each thread, emptied twenty times a second by a thread of the trace's own; what finds it full is
/// counted as lost. The file is complete after finish(); one of a process that was killed is only cut off, which the
/// viewers accept.
class Trace {
 public:
  /// Opens the file. Throws std::runtime_error with the path and the system's reason.
  explicit Trace(const std::string& path);
  ~Trace();  ///< finishes, and lets errors be
  Trace(const Trace&) = delete;
  Trace& operator=(const Trace&) = delete;

  // --- the engine's
  /// Once, before the first event: the rows' names, and those of the nodes (0 the source, the last one the delivery).
  void start(std::vector<std::string> threads, std::vector<std::string> nodes, std::vector<std::string> drop_reasons);
  /// By the thread of that number only; wait-free, allocates nothing.
  void record(int thread, const TraceEvent& event) { rings_[static_cast<std::size_t>(thread)]->put(event); }

  /// Writes what is left and closes. Not while anybody records. Throws std::runtime_error if not all was written.
  void finish();
  std::uint64_t lost() const;

 private:
  void write_while_open();
  void write_all();
  void write(int thread, const TraceEvent& event);
  void write_names();
  void line(const char* format, ...) __attribute__((format(printf, 2, 3)));

  std::string path_;
  std::FILE* file_ = nullptr;
  bool failed_ = false, first_ = true;
  std::vector<std::string> threads_, nodes_, drop_reasons_;
  std::vector<std::unique_ptr<EventRing<TraceEvent>>> rings_;
  std::atomic<bool> ended_{false};
  EventCount end_there_;
  std::jthread writer_;  // last
};

}  // namespace pavo
