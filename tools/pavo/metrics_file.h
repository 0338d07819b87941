// What the run looks like from second to second.
#pragma once

#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <thread>
#include <vector>

#include "drivers/trajectories/append_file.h"
#include "engine/histogram_interval.h"
#include "engine/runtime.h"

namespace pavo {

/// What a camera tells of itself by now, as in report.json; null for other sources. Any thread.
using TellCamera = std::function<nlohmann::ordered_json()>;

/// Counts so far, and latencies since the last look. One looker.
class RunLook {
 public:
  RunLook(const Runtime& runtime, TellCamera camera);
  /// docs/output.md lists the members.
  nlohmann::ordered_json json();
  /// "29.8 a second, age 35 ms (p99 60), 2 in flight, 3 dropped (2 replaced, 1 stale), 0 failed"; and where
  /// the camera is away, that.
  std::string line();

 private:
  struct Stage {
    std::string name;
    const StageMetrics* metrics;
    HistogramInterval wait, service, cpu;
  };
  /// Seconds since the last look.
  double step();
  double rate(const Counts& counts, double seconds);

  const Runtime& runtime_;
  TellCamera camera_;
  std::vector<Stage> stages_;
  HistogramInterval end_to_end_, age_, jitter_, in_flight_;
  double t_begin_s_, t_last_s_;
  std::uint64_t out_last_ = 0;
};

/// A line of JSON a second, written whole at once, so that a reader who follows the file sees whole lines; one more at
/// the end. By a thread of its own.
class MetricsFile {
 public:
  /// Throws std::runtime_error with the path and the system's reason.
  MetricsFile(const std::string& path, const Runtime& runtime, TellCamera camera);
  ~MetricsFile();  ///< lets errors be
  MetricsFile(const MetricsFile&) = delete;
  MetricsFile& operator=(const MetricsFile&) = delete;
  /// The last line. Throws std::runtime_error if any could not be written.
  void finish();

 private:
  void write_until(const std::stop_token& stop);
  void write_line();

  AppendFile file_;
  RunLook look_;
  std::string error_;
  std::mutex mutex_;
  std::condition_variable_any ended_;
  std::jthread thread_;
};

}  // namespace pavo
