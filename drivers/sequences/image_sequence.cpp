#include "drivers/sequences/image_sequence.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "drivers/sequences/file_descriptor.h"

namespace pavo {
namespace {

constexpr std::size_t kFilesAhead = 8;
constexpr std::int64_t kLargestFile = std::int64_t{1} << 30;

[[noreturn]] void fail(const std::string& path, int error) {
  throw FrameError(path + ": cannot be read: " + std::generic_category().message(error));
}

FileDescriptor open_file(const std::string& path) {
  // O_NONBLOCK: a pipe among the images must not hang the run. It means nothing to regular files.
  return FileDescriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
}

/// Asks the kernel to fetch the file; whatever goes wrong shows when the file is read.
void fetch_ahead(const std::string& path) {
  const FileDescriptor file = open_file(path);
  if (file.get() >= 0) ::posix_fadvise(file.get(), 0, 0, POSIX_FADV_WILLNEED);
}

/// By the median, so that pauses do not count.
double rate_of(const std::vector<FrameFile>& frames) {
  std::vector<std::int64_t> periods_ns;
  for (std::size_t i = 1; i < frames.size(); ++i) periods_ns.push_back(frames[i].t_ns - frames[i - 1].t_ns);
  if (periods_ns.empty()) return 0;
  const auto median = periods_ns.begin() + static_cast<std::ptrdiff_t>(periods_ns.size() / 2);
  std::nth_element(periods_ns.begin(), median, periods_ns.end());
  return 1e9 / static_cast<double>(*median);
}

}  // namespace

void read_image_file(const std::string& path, std::vector<std::uint8_t>& bytes) {
  const FileDescriptor file = open_file(path);
  if (file.get() < 0) fail(path, errno);
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) fail(path, errno);
  if (!S_ISREG(status.st_mode)) throw FrameError(path + ": is no regular file: expected an image");
  if (status.st_size == 0) throw FrameError(path + ": is empty: expected an image");
  if (status.st_size > kLargestFile) throw FrameError(path + ": has more than 1 GiB: expected an image");
  bytes.resize(static_cast<std::size_t>(status.st_size));
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got = ::read(file.get(), bytes.data() + done, bytes.size() - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(path, errno);
    if (got == 0) break;  // it has become shorter since fstat: the decoder will tell
    done += static_cast<std::size_t>(got);
  }
  bytes.resize(done);
  if (done == 0) throw FrameError(path + ": is empty: expected an image");
}

ImageSequence::ImageSequence(Recording recording) : recording_(std::move(recording)) {
  recording_.info.frame_count = static_cast<std::int64_t>(recording_.frames.size());
  if (recording_.info.has_times) recording_.info.rate_hz = rate_of(recording_.frames);
  for (std::size_t i = 0; i < std::min(kFilesAhead, recording_.frames.size()); ++i)
    fetch_ahead(recording_.frames[i].path);
}

void ImageSequence::stamp_next(FrameStamp& stamp) const {
  stamp.index = static_cast<std::int64_t>(next_);
  stamp.t_capture_ns = recording_.frames[next_].t_ns;
  stamp.name = recording_.frames[next_].name;
}

std::optional<FrameStamp> ImageSequence::peek() {
  if (at_end()) return std::nullopt;
  FrameStamp stamp;
  stamp_next(stamp);
  return stamp;
}

bool ImageSequence::read(EncodedImage& image, FrameStamp& stamp) {
  if (at_end()) return false;
  stamp_next(stamp);
  const std::string& path = recording_.frames[next_].path;
  ++next_;  // before anything can throw: the next call goes on behind this frame
  if (next_ + kFilesAhead <= recording_.frames.size()) fetch_ahead(recording_.frames[next_ + kFilesAhead - 1].path);
  image.encoding = Encoding::file;
  image.width = image.height = 0;
  image.stride = 0;
  read_image_file(path, image.bytes);
  return true;
}

bool ImageSequence::skip() {
  if (at_end()) return false;
  ++next_;
  return true;
}

}  // namespace pavo
