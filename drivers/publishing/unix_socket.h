// A listening stream socket with a name in the file system.
#pragma once

#include <string>

#include "drivers/publishing/descriptor.h"

namespace pavo {

/// Bound, listening, non-blocking; its file is removed with it. Throws std::runtime_error with one line that begins
/// with `option`: the path is too long, another process serves it, it is a file of another kind, it cannot be made.
class UnixServer {
 public:
  UnixServer(std::string path, const std::string& option);
  ~UnixServer();
  UnixServer(const UnixServer&) = delete;
  UnixServer& operator=(const UnixServer&) = delete;

  int fd() const { return socket_.get(); }
  /// The next one who connects, non-blocking; an empty descriptor where nobody waits.
  OwnedDescriptor accept() const;

 private:
  std::string path_;
  OwnedDescriptor socket_;
};

}  // namespace pavo
