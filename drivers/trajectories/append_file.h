// A text file that grows line by line during a run, and of which nothing is lost when the run ends badly.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace pavo {

/// Creates (or empties) a file and appends to it.
///
/// What survives what: append() hands all its bytes to the kernel before it returns, so whatever was appended outlives
/// the process, however that ends. Where only a part fits (a full disk), the file is cut back to what was complete
/// before, so that it always ends with a whole line. close() waits until the disk has everything (fsync): from then on
/// it outlives a power failure too; before, a power failure may cost the last seconds.
///
/// Called by one thread. Blocks for the file system; allocates nothing after construction. Every failure (open, write,
/// sync, close) is a std::runtime_error "PATH: what failed: the system's reason". Not copyable.
class AppendFile {
 public:
  /// `name` stands for the file in messages, where it is not the path.
  explicit AppendFile(const std::string& path, const std::string& name = "");
  ~AppendFile();  ///< closes without waiting for the disk, and swallows errors: call close() to hear of them
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;

  void append(std::string_view bytes);
  void close();  ///< a second call does nothing; append() afterwards throws std::logic_error

 private:
  [[noreturn]] void fail(const char* what, int error) const;

  std::string name_;
  int fd_ = -1;
  std::int64_t size_ = 0;  ///< bytes of complete appends
};

/// The whole of a file. Throws std::runtime_error, with the path and the reason, where it cannot be read, is a
/// directory, or has more than `limit` bytes.
std::string read_whole_file(const std::string& path, std::size_t limit = std::size_t{1} << 30);

/// Writes (or replaces) a small file as one: first under "PATH.part" and then renamed, so that PATH is the old file or
/// the whole new one, never half of it. Where PATH is no ordinary file (a pipe, a device) it is written directly.
void write_whole_file(const std::string& path, std::string_view bytes);

}  // namespace pavo
