#include "drivers/v4l2/system_calls.h"

#include <fcntl.h>
#include <sys/inotify.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

namespace pavo::v4l2 {
namespace {

int or_error(int result) {
  return result < 0 ? -errno : result;
}

}  // namespace

int Kernel::open(const std::string& path) {
  return or_error(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
}

void Kernel::close(int fd) {
  ::close(fd);
}

int Kernel::ioctl(int fd, unsigned long request, void* argument) {
  return or_error(::ioctl(fd, request, argument));
}

// For writing, too: some drivers of old refuse maps that are for reading only.
void* Kernel::map(int fd, std::size_t bytes, std::int64_t offset) {
  void* start = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, offset);
  return start == MAP_FAILED ? nullptr : start;
}

void Kernel::unmap(void* start, std::size_t bytes) {
  ::munmap(start, bytes);
}

int Kernel::poll(std::span<pollfd> descriptors, std::int64_t timeout_ns) {
  const timespec timeout{.tv_sec = timeout_ns / 1'000'000'000, .tv_nsec = timeout_ns % 1'000'000'000};
  return or_error(::ppoll(descriptors.data(), descriptors.size(), timeout_ns < 0 ? nullptr : &timeout, nullptr));
}

int Kernel::watch(const std::string& directory) {
  const int fd = ::inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  if (fd < 0) return -errno;
  // IN_ATTRIB: udev makes the node first, and gives it to its group afterwards.
  if (::inotify_add_watch(fd, directory.c_str(), IN_CREATE | IN_MOVED_TO | IN_ATTRIB) >= 0) return fd;
  const int error = errno;
  ::close(fd);
  return -error;
}

void Kernel::forget_events(int fd) {
  std::array<char, 4096> events;
  while (::read(fd, events.data(), events.size()) > 0) {
  }
}

std::int64_t Kernel::now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

int ioctl_again(SystemCalls& system, int fd, unsigned long request, void* argument) {
  constexpr int kPatience = 1000;
  int result = -EINTR;
  for (int n = 0; n < kPatience && result == -EINTR; ++n) result = system.ioctl(fd, request, argument);
  return result;
}

std::string reason(int error) {
  return std::generic_category().message(error < 0 ? -error : error);
}

}  // namespace pavo::v4l2
