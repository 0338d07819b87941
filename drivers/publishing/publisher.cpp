#include "drivers/publishing/publisher.h"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "drivers/publishing/unix_socket.h"

namespace pavo {
namespace {

constexpr std::size_t kMostReaders = 64;

bool would_block(int error) {
  return error == EAGAIN || error == EWOULDBLOCK || error == ENOBUFS;
}

/// What a reader was given a part of: it gets the rest before anything else.
class Tail {
 public:
  Tail() { rest_.reserve(kLongestLine); }
  bool empty() const { return rest_.empty(); }
  void keep(std::string_view rest) { rest_.assign(rest); }
  void drop_front(std::size_t bytes) { rest_.erase(0, bytes); }
  const std::string& text() const { return rest_; }

 private:
  std::string rest_;
};

enum class Sent { all, none, gone };

/// write(2) that says how much it took: 0 where it would have blocked; nothing where the reader is gone.
template <typename Write>
std::optional<std::size_t> taken_by(const Write& write, std::string_view bytes) {
  for (;;) {
    const ssize_t n = write(bytes);
    if (n >= 0) return static_cast<std::size_t>(n);
    if (errno == EINTR) continue;
    if (would_block(errno)) return 0;
    return std::nullopt;
  }
}

/// Writes the tail, then the line, with `write(bytes) -> ssize_t`, which does not block.
template <typename Write>
Sent send_behind(Tail& tail, std::string_view line, const Write& write) {
  if (!tail.empty()) {
    const auto taken = taken_by(write, tail.text());
    if (!taken) return Sent::gone;
    tail.drop_front(*taken);
    if (!tail.empty()) return Sent::none;
  }
  const auto taken = taken_by(write, line);
  if (!taken) return Sent::gone;
  if (*taken == 0) return Sent::none;
  tail.keep(line.substr(*taken));
  return Sent::all;  // or the rest of it is on its way
}

/// A pipe that poll() calls writable takes PIPE_BUF bytes without blocking, and as a whole.
class StandardOutput final : public Publisher {
 public:
  /// Whatever else the program prints goes to the standard error from now on, so that it does not come between.
  StandardOutput() : out_(::dup(STDOUT_FILENO)) {
    if (!out_ || ::dup2(STDERR_FILENO, STDOUT_FILENO) < 0)
      throw std::runtime_error("--publish -: there is no standard output: " + std::generic_category().message(errno));
    counts_.readers = counts_.connected = 1;
  }

 private:
  void send(std::string_view line) override {
    if (counts_.readers == 0) {
      ++counts_.unread;
      return;
    }
    const Sent sent = send_behind(tail_, line, [this](std::string_view bytes) -> ssize_t {
      pollfd fd{out_.get(), POLLOUT, 0};
      const int ready = ::poll(&fd, 1, 0);
      if (ready > 0 && !(fd.revents & (POLLERR | POLLNVAL))) return ::write(out_.get(), bytes.data(), bytes.size());
      if (ready > 0) errno = EPIPE;
      if (ready == 0) errno = EAGAIN;
      return -1;
    });
    if (sent == Sent::gone) counts_.readers = 0;
    ++(sent == Sent::all ? counts_.sent : counts_.lost);
  }

  OwnedDescriptor out_;
  Tail tail_;
};

class UnixReaders final : public Publisher {
 public:
  UnixReaders(const std::string& path, const std::string& option) : server_(path, option) {}

 private:
  struct Reader {
    OwnedDescriptor socket;
    Tail tail;
  };

  void send(std::string_view line) override {
    welcome();
    if (readers_.empty()) ++counts_.unread;
    for (Reader& reader : readers_) {
      const Sent sent = send_behind(reader.tail, line, [&](std::string_view bytes) {
        return ::send(reader.socket.get(), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
      });
      if (sent == Sent::gone) reader.socket = OwnedDescriptor();
      ++(sent == Sent::all ? counts_.sent : counts_.lost);
    }
    std::erase_if(readers_, [](const Reader& reader) { return !reader.socket; });
    counts_.readers = readers_.size();
  }

  void welcome() {
    while (OwnedDescriptor caller = server_.accept()) {
      if (readers_.size() == kMostReaders) continue;  // and hung up on
      readers_.push_back({std::move(caller), {}});
      ++counts_.connected;
    }
  }

  UnixServer server_;
  std::vector<Reader> readers_;
};

struct HostPort {
  std::string host, port;
};

/// HOST:PORT or [HOST]:PORT; an empty port where it is neither.
HostPort split(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos || colon == 0) return {};
  std::string host = text.substr(0, colon), port = text.substr(colon + 1);
  const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  if (bracketed) host = host.substr(1, host.size() - 2);
  const bool digits = std::all_of(port.begin(), port.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (!digits || port.empty() || port.size() > 5 || std::stoi(port) < 1 || std::stoi(port) > 65535) return {};
  if (!bracketed && host.find(':') != std::string::npos) return {};
  return {host, port};
}

class Datagrams final : public Publisher {
 public:
  Datagrams(const std::string& target, const std::string& option) {
    const HostPort to = split(target);
    addrinfo hints{}, *found = nullptr;
    hints.ai_socktype = SOCK_DGRAM;
    if (const int error = ::getaddrinfo(to.host.c_str(), to.port.c_str(), &hints, &found); error != 0)
      throw std::runtime_error(option + ": no such host: " + ::gai_strerror(error));
    int error = 0;
    for (const addrinfo* a = found; a && !socket_; a = a->ai_next) {
      OwnedDescriptor made(::socket(a->ai_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, a->ai_protocol));
      if (made && ::connect(made.get(), a->ai_addr, a->ai_addrlen) == 0)
        socket_ = std::move(made);
      else
        error = errno;
    }
    ::freeaddrinfo(found);
    if (!socket_) throw std::runtime_error(option + ": cannot be sent to: " + std::generic_category().message(error));
    counts_.readers = counts_.connected = 1;
  }

 private:
  /// An earlier datagram that nobody took comes back as an error of this call, which then has sent nothing.
  void send(std::string_view line) override {
    const ssize_t n = ::send(socket_.get(), line.data(), line.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    ++(n == static_cast<ssize_t>(line.size()) ? counts_.sent : counts_.lost);
  }

  OwnedDescriptor socket_;
};

}  // namespace

void Publisher::publish(std::string_view line) {
  if (line.size() > kLongestLine)
    throw std::invalid_argument("a line to publish has " + std::to_string(line.size()) + " bytes; expected at most " +
                                std::to_string(kLongestLine));
  ++counts_.lines;
  send(line);
}

std::string invalid_publish_target(const std::string& where) {
  if (where == "-" || (where.starts_with("unix:") && where.size() > 5)) return "";
  if (where.starts_with("udp:") && !split(where.substr(4)).port.empty()) return "";
  return "must be - (standard output), unix:PATH or udp:HOST:PORT, not '" + where + "'";
}

std::unique_ptr<Publisher> open_publisher(const std::string& where) {
  const std::string option = "--publish " + where;
  if (const std::string wrong = invalid_publish_target(where); !wrong.empty())
    throw std::runtime_error("--publish " + wrong);
  if (where.starts_with("unix:")) return std::make_unique<UnixReaders>(where.substr(5), option);
  if (where.starts_with("udp:")) return std::make_unique<Datagrams>(where.substr(4), option);
  // Whoever reads our standard output may go before we do; that is no reason to die.
  std::signal(SIGPIPE, SIG_IGN);
  return std::make_unique<StandardOutput>();
}

}  // namespace pavo
