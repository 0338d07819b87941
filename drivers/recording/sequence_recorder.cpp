#include "drivers/recording/sequence_recorder.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <system_error>

namespace pavo {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const std::string& what, int error) {
  throw std::runtime_error(path.string() + ": " + what + ": " + std::generic_category().message(error));
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder))
    throw std::runtime_error(folder.string() +
                             ": this folder cannot be made: " + (error ? error.message() : "it is no directory"));
}

/// Returns `folder`, which has nothing in it.
fs::path made_empty(const fs::path& folder) {
  make_folder(folder);
  std::error_code error;
  const bool empty = fs::is_empty(folder, error);
  if (error) throw std::runtime_error(folder.string() + ": cannot be read: " + error.message());
  if (!empty) throw std::runtime_error(folder.string() + ": is not empty: record into a folder that is new or empty");
  return folder;
}

/// Where the index and the calibration are, made.
fs::path made_base(const fs::path& folder, RecordLayout layout) {
  fs::path base = layout == RecordLayout::euroc ? made_empty(folder) / "mav0" / "cam0" : made_empty(folder);
  make_folder(base / (layout == RecordLayout::euroc ? "data" : "image_0"));
  return base;
}

/// The name appears when all bytes are there.
void write_image(const fs::path& path, const std::vector<std::uint8_t>& bytes) {
  const std::string part = path.string() + ".part";
  const int fd = ::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd < 0) fail(path, "cannot be written", errno);
  int error = 0;
  for (std::size_t at = 0; at < bytes.size() && error == 0;) {
    const ssize_t n = ::write(fd, bytes.data() + at, bytes.size() - at);
    if (n >= 0)
      at += static_cast<std::size_t>(n);
    else if (errno != EINTR)
      error = errno;
  }
  if (::close(fd) != 0 && error == 0 && errno != EINTR) error = errno;
  if (error == 0 && std::rename(part.c_str(), path.c_str()) != 0) error = errno;
  if (error == 0) return;
  ::unlink(part.c_str());  // leaves room for the index's last lines
  fail(path, "cannot be written", error);
}

std::string seconds_text(std::int64_t t_ns) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  char text[40];
  std::snprintf(text, sizeof text, "%s%lld.%09lld\n", t_ns < 0 ? "-" : "", std::llabs(t_ns / kSecond),
                std::llabs(t_ns % kSecond));
  return text;
}

std::string number_text(std::uint64_t number) {
  char text[24];
  std::snprintf(text, sizeof text, "%06llu", static_cast<unsigned long long>(number));
  return text;
}

}  // namespace

SequenceRecorder::SequenceRecorder(const fs::path& folder, const RecorderOptions& options,
                                   const std::function<EncodeFrame()>& make_encoder)
    : options_(options),
      folder_(made_base(folder, options.layout)),
      images_(folder_ / (options.layout == RecordLayout::euroc ? "data" : "image_0")),
      index_((folder_ / (options.layout == RecordLayout::euroc ? "data.csv" : "times.txt")).string()) {
  for (const auto& [name, contents] : options_.files) write_whole_file((folder_ / name).string(), contents);
  if (options_.layout == RecordLayout::euroc) index_.append("#timestamp [ns],filename\n");
  for (int i = 0; i < options_.waiting + options_.encoders; ++i) unused_.push_back(std::make_unique<Job>());
  for (int i = 0; i < options_.encoders; ++i)
    threads_.emplace_back(
        [this, encode_frame = make_encoder()](const std::stop_token& stop) { work(stop, encode_frame); });
}

SequenceRecorder::~SequenceRecorder() {
  for (std::jthread& thread : threads_) thread.request_stop();
}

bool SequenceRecorder::offer(EncodedImage& frame, std::int64_t t_ns) {
  if (next_number_ > 0 && t_ns <= last_ns_)
    throw std::runtime_error("a frame's time is not later than that of the one before it, at " + std::to_string(t_ns) +
                             " ns: a sequence needs times that increase");
  std::unique_lock lock(mutex_);
  ++counts_.offered;
  if (options_.wait_for_room) changed_.wait(lock, [this] { return !unused_.empty() || error_; });
  if (error_ || unused_.empty()) {
    ++counts_.no_room;
    return false;
  }
  std::unique_ptr<Job> job = std::move(unused_.back());
  unused_.pop_back();
  std::swap(job->frame, frame);
  job->t_ns = last_ns_ = t_ns;
  job->number = next_number_++;
  // KITTI's lines stand for the numbers of the images: each is written just before its image.
  lines_.push_back(is_euroc() ? std::nullopt : std::optional(seconds_text(t_ns)));
  waiting_.push_back(std::move(job));
  lock.unlock();
  changed_.notify_all();
  return true;
}

void SequenceRecorder::finish() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  changed_.notify_all();
  for (std::jthread& thread : threads_)
    if (thread.joinable()) thread.join();
  if (error_) std::rethrow_exception(error_);
  index_.close();
  const int fd = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool synced = fd >= 0 && ::syncfs(fd) == 0;
  const int error = errno;
  if (fd >= 0) ::close(fd);
  if (!synced) fail(folder_, "did not reach the disk", error);
}

bool SequenceRecorder::failed() const {
  const std::lock_guard lock(mutex_);
  return error_ != nullptr;
}

std::string SequenceRecorder::first_failure() const {
  const std::lock_guard lock(mutex_);
  return first_failure_;
}

RecordCounts SequenceRecorder::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

void SequenceRecorder::work(const std::stop_token& stop, const EncodeFrame& encode) {
  std::vector<std::uint8_t> file;
  while (std::unique_ptr<Job> job = next_job(stop)) {
    try {
      record(*job, encode, file);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!error_) error_ = std::current_exception();
      ++counts_.no_room;
    }
    const std::lock_guard lock(mutex_);
    unused_.push_back(std::move(job));
    changed_.notify_all();
  }
}

std::unique_ptr<SequenceRecorder::Job> SequenceRecorder::next_job(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, stop, [this] { return !waiting_.empty() || ended_ || error_; });
  if (error_) {  // what waits is not written any more
    counts_.no_room += waiting_.size();
    waiting_.clear();
  }
  if (stop.stop_requested() || waiting_.empty()) return nullptr;
  std::unique_ptr<Job> job = std::move(waiting_.front());
  waiting_.pop_front();
  return job;
}

// A frame that cannot be encoded is left out; what cannot be written ends the recording.
void SequenceRecorder::record(Job& job, const EncodeFrame& encode, std::vector<std::uint8_t>& file) {
  std::string name, failure;
  try {
    name = (is_euroc() ? std::to_string(job.t_ns) : number_text(job.number)) + std::string(encode(job.frame, file));
  } catch (const std::exception& e) {
    failure = *e.what() ? e.what() : "it could not be encoded";
  }
  if (!is_euroc()) flush_index(job.number);
  if (failure.empty()) write_image(images_ / name, file);
  {
    const std::lock_guard lock(mutex_);
    if (failure.empty()) {
      ++counts_.written;
      counts_.bytes += file.size();
    } else if (counts_.failed++ == 0) {
      first_failure_ = failure;
    }
    if (is_euroc())
      lines_[job.number - next_line_] = failure.empty() ? std::to_string(job.t_ns) + "," + name + "\n" : std::string();
  }
  if (is_euroc()) flush_index(std::numeric_limits<std::uint64_t>::max());
}

// The lines that are known, whose turn it is, up to the frame `last`. In order, since one thread at a time does it.
void SequenceRecorder::flush_index(std::uint64_t last) {
  const std::lock_guard index_lock(index_mutex_);
  std::string text;
  {
    const std::lock_guard lock(mutex_);
    for (; next_line_ <= last && !lines_.empty() && lines_.front(); lines_.pop_front(), ++next_line_)
      text += *lines_.front();
  }
  if (!text.empty()) index_.append(text);
}

}  // namespace pavo
