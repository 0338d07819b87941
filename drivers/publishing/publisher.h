// Lines of text to whoever reads them, at once, and never waiting for anybody.
//
//   auto publisher = open_publisher("unix:/run/pavo.sock");
//   publisher->publish(line);   // '\n' at its end
//
// "-"              the standard output, one reader
// "unix:PATH"      a stream socket that is made here: any number of readers connect to PATH, and may come and go
// "udp:HOST:PORT"  a datagram a line, to one address; "udp:[::1]:9000" for an IPv6 address
//
// For sockets pavo is the server, since it is the one that runs for days, and its readers are started and stopped
// beside it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace pavo {

struct PublishCounts {
  std::uint64_t lines = 0;      ///< published
  std::uint64_t sent = 0;       ///< times a reader was given a line
  std::uint64_t lost = 0;       ///< times a reader missed a line: it is slow, or not there (udp)
  std::uint64_t unread = 0;     ///< lines that were published while there was no reader
  std::uint64_t readers = 0;    ///< now
  std::uint64_t connected = 0;  ///< readers that there ever were
};

/// The longest line that is sure to pass whole: PIPE_BUF.
inline constexpr std::size_t kLongestLine = 4096;

/// publish() is called by one thread, counts() by the same. Neither blocks (standard output: as long as it is no file
/// on a disk that hangs), and publish() allocates only when a reader comes. The destructor closes everything, and
/// removes PATH.
class Publisher {
 public:
  virtual ~Publisher() = default;
  /// A reader that cannot take the line now loses it; whoever gets it, gets all of it. Throws std::invalid_argument
  /// where it is longer than kLongestLine.
  void publish(std::string_view line);
  const PublishCounts& counts() const { return counts_; }

 protected:
  virtual void send(std::string_view line) = 0;
  PublishCounts counts_;
};

/// What is wrong with the text, or "".
std::string invalid_publish_target(const std::string& where);

/// Throws std::runtime_error with one line: the target, what is wrong, what to do. A socket's file that nobody serves
/// any more is replaced; one that is served, or a file of another kind, is an error.
std::unique_ptr<Publisher> open_publisher(const std::string& where);

}  // namespace pavo
