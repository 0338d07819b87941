#include "drivers/publishing/unix_socket.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>

namespace pavo {
namespace {

constexpr int kBacklog = 16;

[[noreturn]] void fail(const std::string& option, const std::string& what) {
  throw std::runtime_error(option + ": " + what);
}

std::string reason(int error) {
  return std::generic_category().message(error);
}

sockaddr_un address_of(const std::string& path, const std::string& option) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty()) fail(option, "the path is empty: expected unix:PATH");
  if (path.size() >= sizeof address.sun_path)
    fail(option, "the path is longer than the " + std::to_string(sizeof address.sun_path - 1) +
                     " bytes that the system allows a socket: give a shorter one");
  std::memcpy(address.sun_path, path.data(), path.size());
  return address;
}

OwnedDescriptor new_socket(const std::string& option) {
  OwnedDescriptor made(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!made) fail(option, "the system gives no socket: " + reason(errno));
  return made;
}

/// A socket that a process left behind when it ended badly: nobody answers there.
void remove_if_abandoned(const std::string& path, const sockaddr_un& address, const std::string& option) {
  struct stat info {};
  if (::lstat(path.c_str(), &info) != 0) return;
  if (!S_ISSOCK(info.st_mode)) fail(option, "this is a file, and no socket: give another path");
  const OwnedDescriptor caller = new_socket(option);
  const int result = ::connect(caller.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address);
  if (result == 0 || errno != ECONNREFUSED) fail(option, "another process serves it already: give another path");
  ::unlink(path.c_str());
}

}  // namespace

UnixServer::UnixServer(std::string path, const std::string& option) : path_(std::move(path)) {
  const sockaddr_un address = address_of(path_, option);
  remove_if_abandoned(path_, address, option);
  OwnedDescriptor made = new_socket(option);
  if (::bind(made.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    fail(option, "cannot be made: " + reason(errno));
  if (::listen(made.get(), kBacklog) != 0) {
    const int error = errno;
    ::unlink(path_.c_str());
    fail(option, "cannot be listened to: " + reason(error));
  }
  socket_ = std::move(made);
}

UnixServer::~UnixServer() {
  if (socket_) ::unlink(path_.c_str());
}

OwnedDescriptor UnixServer::accept() const {
  for (;;) {
    OwnedDescriptor caller(::accept4(socket_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (caller || (errno != EINTR && errno != ECONNABORTED)) return caller;
  }
}

}  // namespace pavo
