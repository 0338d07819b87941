// The few system calls that the camera driver is made of, behind a seam: tests play a kernel that is late, full, broken
// or unplugged at the right moment.
#pragma once

#include <poll.h>
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

namespace pavo::v4l2 {

/// What fails returns -errno: nothing between the call and its look can change it then. Any thread.
class SystemCalls {
 public:
  virtual ~SystemCalls() = default;
  virtual int open(const std::string& path) = 0;  ///< for reading and writing, without blocking
  virtual void close(int fd) = 0;
  virtual int ioctl(int fd, unsigned long request, void* argument) = 0;
  /// nullptr where it cannot be mapped.
  virtual void* map(int fd, std::size_t bytes, std::int64_t offset) = 0;
  virtual void unmap(void* start, std::size_t bytes) = 0;
  /// A negative time-out is none.
  virtual int poll(std::span<pollfd> descriptors, std::int64_t timeout_ns) = 0;
  /// A descriptor that becomes readable when names come to a directory, or change their owner; -errno without one.
  virtual int watch(const std::string& directory) = 0;
  /// Takes what has happened off such a descriptor.
  virtual void forget_events(int fd) = 0;
  virtual std::int64_t now_ns() = 0;  ///< CLOCK_MONOTONIC
};

/// The machine's own.
class Kernel final : public SystemCalls {
 public:
  int open(const std::string& path) override;
  void close(int fd) override;
  int ioctl(int fd, unsigned long request, void* argument) override;
  void* map(int fd, std::size_t bytes, std::int64_t offset) override;
  void unmap(void* start, std::size_t bytes) override;
  int poll(std::span<pollfd> descriptors, std::int64_t timeout_ns) override;
  int watch(const std::string& directory) override;
  void forget_events(int fd) override;
  std::int64_t now_ns() override;
};

/// Again, where a signal came in between. A driver that says EINTR for ever is given up as broken.
int ioctl_again(SystemCalls& system, int fd, unsigned long request, void* argument);

/// "No such device", for messages.
std::string reason(int error);

/// Owns an open descriptor; a negative one is none.
class Descriptor {
 public:
  Descriptor() = default;
  Descriptor(SystemCalls& system, int fd) : system_(&system), fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : system_(other.system_), fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(system_, other.system_);
    std::swap(fd_, other.fd_);
    return *this;
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) system_->close(fd_);
  }
  int get() const { return fd_; }

 private:
  SystemCalls* system_ = nullptr;
  int fd_ = -1;
};

/// Owns a part of a driver's memory that is mapped into ours.
class Mapping {
 public:
  Mapping(SystemCalls& system, void* start, std::size_t bytes) : system_(&system), start_(start), bytes_(bytes) {}
  Mapping(Mapping&& other) noexcept
      : system_(other.system_), start_(std::exchange(other.start_, nullptr)), bytes_(other.bytes_) {}
  Mapping& operator=(Mapping&&) = delete;
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;
  ~Mapping() {
    if (start_) system_->unmap(start_, bytes_);
  }
  std::span<const std::uint8_t> bytes() const { return {static_cast<const std::uint8_t*>(start_), bytes_}; }

 private:
  SystemCalls* system_;
  void* start_;
  std::size_t bytes_;
};

}  // namespace pavo::v4l2
