#include "drivers/trajectories/sync_each_second.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>

namespace pavo {

SyncEachSecond::SyncEachSecond(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    struct stat info {};
    if (::stat(path.c_str(), &info) != 0 || !S_ISREG(info.st_mode)) continue;  // opening a pipe would wait
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd >= 0) descriptors_.push_back(fd);
  }
  thread_ = std::jthread([this](const std::stop_token& stop) { sync_until(stop); });
}

SyncEachSecond::~SyncEachSecond() {
  thread_.request_stop();
  thread_.join();
  for (const int fd : descriptors_) ::close(fd);
}

void SyncEachSecond::sync_until(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!ended_.wait_for(lock, stop, std::chrono::seconds(1), [&stop] { return stop.stop_requested(); }))
    for (const int fd : descriptors_) (void)::fdatasync(fd);
}

}  // namespace pavo
