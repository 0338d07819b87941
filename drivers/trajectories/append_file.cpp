#include "drivers/trajectories/append_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <stdexcept>
#include <system_error>

namespace pavo {
namespace {

std::string reason(int error) {
  return std::generic_category().message(error);
}

[[noreturn]] void fail_at(const std::string& path, const char* what, int error) {
  throw std::runtime_error(path + ": " + what + ": " + reason(error));
}

}  // namespace

AppendFile::AppendFile(const std::string& path, const std::string& name) : name_(name.empty() ? path : name) {
  do {
    fd_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  } while (fd_ < 0 && errno == EINTR);
  if (fd_ < 0) fail("cannot be written", errno);
}

AppendFile::~AppendFile() {
  if (fd_ >= 0) ::close(fd_);
}

void AppendFile::fail(const char* what, int error) const {
  fail_at(name_, what, error);
}

void AppendFile::append(std::string_view bytes) {
  if (fd_ < 0) throw std::logic_error(name_ + ": appended to after it was closed");
  std::string_view rest = bytes;
  while (!rest.empty()) {
    const ssize_t written = ::write(fd_, rest.data(), rest.size());
    if (written >= 0) {
      rest.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno != EINTR) {
      const int error = errno;
      // Half a line would read as garbage: go back to the last whole one. Pipes and devices cannot, and need not.
      if (::ftruncate(fd_, size_) == 0) ::lseek(fd_, size_, SEEK_SET);
      fail("writing failed", error);
    }
  }
  size_ += static_cast<std::int64_t>(bytes.size());
}

void AppendFile::close() {
  if (fd_ < 0) return;
  // EINVAL and ENOTSUP: a pipe or a device, which has no disk to wait for.
  const int sync_error = ::fsync(fd_) == 0 || errno == EINVAL || errno == ENOTSUP ? 0 : errno;
  const int close_error = ::close(fd_) == 0 || errno == EINTR ? 0 : errno;
  fd_ = -1;
  if (sync_error) fail("did not reach the disk", sync_error);
  if (close_error) fail("closing failed", close_error);
}

std::string read_whole_file(const std::string& path, std::size_t limit) {
  struct Closer {
    int fd;
    ~Closer() {
      if (fd >= 0) ::close(fd);
    }
  } file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (file.fd < 0) fail_at(path, "cannot be read", errno);
  std::string bytes;
  std::array<char, 65536> block{};
  while (true) {
    const ssize_t got = ::read(file.fd, block.data(), block.size());
    if (got == 0) return bytes;
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail_at(path, "cannot be read", errno);
    if (bytes.size() + static_cast<std::size_t>(got) > limit)
      throw std::runtime_error(path + ": more than " + std::to_string(limit) + " bytes: not what is expected here");
    bytes.append(block.data(), static_cast<std::size_t>(got));
  }
}

void write_whole_file(const std::string& path, std::string_view bytes) {
  struct stat info {};
  const bool special = ::stat(path.c_str(), &info) == 0 && !S_ISREG(info.st_mode);
  const std::string part = special ? path : path + ".part";
  try {
    AppendFile file(part, path);
    file.append(bytes);
    file.close();
  } catch (...) {
    if (!special) ::unlink(part.c_str());
    throw;
  }
  if (!special && std::rename(part.c_str(), path.c_str()) != 0) {
    const int error = errno;
    ::unlink(part.c_str());
    fail_at(path, "cannot be written", error);
  }
}

}  // namespace pavo
