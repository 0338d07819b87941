// The other end of a socket, as a reader or a feeder has it.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <cstring>
#include <string>
#include <vector>

#include "drivers/publishing/descriptor.h"

namespace pavo::test {

inline sockaddr_un address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), std::min(path.size(), sizeof address.sun_path - 1));
  return address;
}

inline OwnedDescriptor connected_to(const std::string& path) {
  OwnedDescriptor made(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const sockaddr_un address = address_of(path);
  if (::connect(made.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return {};
  return made;
}

/// What lies there now.
inline std::string received(const OwnedDescriptor& from) {
  std::string all;
  char block[4096];
  for (ssize_t n; (n = ::recv(from.get(), block, sizeof block, MSG_DONTWAIT)) > 0;)
    all.append(block, static_cast<std::size_t>(n));
  return all;
}

inline std::vector<std::string> lines_in(const std::string& text) {
  std::vector<std::string> lines;
  std::size_t from = 0;
  for (std::size_t end; (end = text.find('\n', from)) != std::string::npos; from = end + 1)
    lines.push_back(text.substr(from, end - from));
  EXPECT_EQ(from, text.size()) << "half a line";
  return lines;
}

}  // namespace pavo::test
