// What is appended to files reaches the disk within a second or two, without anybody waiting for it.
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace pavo {

/// Calls fdatasync() on some files, once a second, by a thread of its own: a power failure costs the last seconds of a
/// run of days, and no more. Errors are left to whoever writes and closes the files: the system tells them to each who
/// has them open.
class SyncEachSecond {
 public:
  /// Files that are there; others, and what has no disk, are passed over.
  explicit SyncEachSecond(const std::vector<std::string>& paths);
  ~SyncEachSecond();
  SyncEachSecond(const SyncEachSecond&) = delete;
  SyncEachSecond& operator=(const SyncEachSecond&) = delete;

 private:
  void sync_until(const std::stop_token& stop);

  std::vector<int> descriptors_;
  std::mutex mutex_;
  std::condition_variable_any ended_;
  std::jthread thread_;  // last
};

}  // namespace pavo
