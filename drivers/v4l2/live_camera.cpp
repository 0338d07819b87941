#include "drivers/v4l2/live_camera.h"

#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>
#include <utility>

namespace pavo::v4l2 {
namespace {

constexpr std::int64_t kMillisecond_ns = 1'000'000;
constexpr std::int64_t kFirstFrame_ns = 5'000 * kMillisecond_ns;  // cameras take seconds to wake up

std::string seconds(std::int64_t ns) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f s", static_cast<double>(ns) * 1e-9);
  return text;
}

// Where names for the camera come up: its own folder, where it is not a link in one that comes and goes itself.
std::string folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos || path.starts_with("/dev/v4l/") ? "/dev"
                                                                     : path.substr(0, std::max<std::size_t>(slash, 1));
}

void ring(int fd) {
  eventfd_write(fd, 1);
}

void copy_bytes(const FilledBuffer& buffer, const StreamFormat& format, EncodedImage& image) {
  const bool compressed = format.stride == 0;
  image.encoding = format.pixels.encoding;
  image.width = compressed ? 0 : format.size.width;
  image.height = compressed ? 0 : format.size.height;
  image.stride = format.stride;
  image.bytes.resize(compressed ? buffer.bytes.size() : format.bytes_needed);
  std::memcpy(image.bytes.data(), buffer.bytes.data(), image.bytes.size());
}

}  // namespace

LiveCamera::LiveCamera(SystemCalls& system, std::string path, CameraOptions options,
                       std::function<void(const std::string&)> tell)
    : system_(system), path_(std::move(path)), options_(std::move(options)), tell_(std::move(tell)) {
  const int fd = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (fd < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
  wake_fd_ = Descriptor(kernel_, fd);
  held_.reserve(static_cast<std::size_t>(std::max(options_.buffers, 2)) * 2);
  open_first();
  thread_ = std::jthread([this] { capture(); });
}

LiveCamera::~LiveCamera() {
  interrupt();
}

// Webcams have been seen to fail their first start after they were plugged in, and only that.
void LiveCamera::open_first() {
  constexpr int kAttempts = 3;
  constexpr std::int64_t kPause_ns = 100 * kMillisecond_ns;
  for (int attempt = 1;; ++attempt) {
    std::string problem;
    int code = 0;
    if (try_to_open(problem, code)) break;
    const bool stumbles = code == EIO || code == EINVAL || code == EPIPE || code == EPROTO || code == ETIMEDOUT;
    if (!stumbles || attempt == kAttempts) throw DeviceError(problem, code);
    system_.poll({}, kPause_ns);
  }
  name_ = session_->device().name();
  format_ = session_->format();
}

bool LiveCamera::try_to_open(std::string& problem, int& code) {
  try {
    auto session =
        std::make_unique<CameraSession>(system_, path_, options_.format, options_.buffers, options_.controls);
    if (!name_.card.empty() && session->device().name().card != name_.card)
      throw DeviceError(path_ + ": is another camera now ('" + session->device().name().card + "'); waiting for '" +
                        name_.card + "', whose calibration was given");
    clock_.started(system_.now_ns());
    sequence_.started();
    first_of_session_ = true;
    const std::lock_guard lock(mutex_);
    session_ = std::move(session);
    report_.name = session_->device().name();
    report_.format = session_->format();
    report_.buffers = session_->stream().buffers();
    report_.streaming = true;
    return true;
  } catch (const DeviceError& e) {
    problem = e.what();
    code = e.code();
    return false;
  }
}

// ---------------------------------------------------------------- the reader

bool LiveCamera::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return ready_.load() || stop_.load(); });
  return !stop_.load() && !(ended_.load() && held_.empty());
}

bool LiveCamera::take(EncodedImage& image, CameraFrame& frame) {
  const std::lock_guard lock(mutex_);
  if (held_.empty()) return false;
  const Held held = held_.front();
  held_.erase(held_.begin());
  if (held_.empty() && !ended_.load()) ready_ = false;
  ++report_.taken;
  frame = held.frame;
  frame.lost_before += std::exchange(lost_unread_, 0);
  frame.after_outage |= std::exchange(outage_unread_, false);
  const StreamFormat& format = session_->format();
  const bool too_short = is_too_short(held.buffer);
  if (!held.buffer.damaged && !too_short) copy_bytes(held.buffer, format, image);
  session_->stream().queue(held.buffer.index);
  if (options_.every_frame) ring(wake_fd_.get());  // there is room again
  if (held.buffer.damaged)
    throw FrameFault("the driver marks its frame " + std::to_string(frame.sequence) + " as damaged");
  if (too_short)
    throw FrameFault("the driver's frame " + std::to_string(frame.sequence) + " has " +
                     std::to_string(held.buffer.bytes.size()) + " bytes; expected " +
                     std::to_string(format.bytes_needed) + " for " + format.text());
  return true;
}

void LiveCamera::on_ready(std::function<void()> wake) {
  const std::lock_guard lock(mutex_);
  wake_ = std::move(wake);
  if (wake_ && ready_.load()) wake_();
}

void LiveCamera::rethrow_error() const {
  if (ended_.load() && error_) std::rethrow_exception(error_);
}

void LiveCamera::interrupt() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  ring(wake_fd_.get());
  changed_.notify_all();
}

std::uint64_t LiveCamera::stale() const {
  const std::lock_guard lock(mutex_);
  return report_.stale;
}

std::uint64_t LiveCamera::stop() {
  interrupt();
  if (thread_.joinable()) thread_.join();
  const std::lock_guard lock(mutex_);
  return held_.size();
}

bool LiveCamera::nothing_held() const {
  const std::lock_guard lock(mutex_);
  return held_.empty();
}

CameraReport LiveCamera::report() const {
  const std::lock_guard lock(mutex_);
  return report_;
}

// ---------------------------------------------------------------- the capture thread

void LiveCamera::capture() {
  pthread_setname_np(pthread_self(), "pavo-capture");
  try {
    while (!stop_.load()) {
      const Fault fault = stream_until_fault();
      if (stop_.load()) break;
      close_session(fault);
      recover(fault);
    }
  } catch (...) {
    error_ = std::current_exception();
  }
  const std::lock_guard lock(mutex_);
  ended_ = true;
  ready_ = true;
  changed_.notify_all();
  if (wake_) wake_();
}

std::int64_t LiveCamera::patience_ns() const {
  constexpr std::int64_t kPeriods = 10;  // in the dark, some cameras give a quarter of their rate
  return std::max(options_.patience_ns, kPeriods * session_->format().period_ns());
}

// Recordings leave the driver two buffers to go on with; what is held is read soon, or lost by the driver.
bool LiveCamera::has_room() const {
  if (!options_.every_frame) return true;
  const std::lock_guard lock(mutex_);
  return static_cast<int>(held_.size()) < std::max(1, session_->stream().buffers() - 2);
}

LiveCamera::Fault LiveCamera::stream_until_fault() {
  std::int64_t deadline = system_.now_ns() + std::max(kFirstFrame_ns, patience_ns());
  while (!stop_.load()) {
    const bool room = has_room();
    std::array<pollfd, 2> fds{
        {{room ? session_->device().fd() : -1, POLLIN, 0}, {.fd = wake_fd_.get(), .events = POLLIN, .revents = 0}}};
    const int n = system_.poll(fds, room ? std::max<std::int64_t>(0, deadline - system_.now_ns()) : -1);
    if (stop_.load()) break;
    if (n < 0 && n != -EINTR) return fault_of(n);
    eventfd_t word = 0;
    if (fds[1].revents) eventfd_read(wake_fd_.get(), &word);
    if (!room) {
      deadline = system_.now_ns() + patience_ns();
      continue;
    }
    bool came = false;
    int result = -EAGAIN;
    // Looked at even where poll() says nothing: a process that was stopped for a while finds its deadline passed, and
    // frames waiting.
    while (!stop_.load() && has_room() && (result = take_in()) == 0) came = true;
    if (came) deadline = system_.now_ns() + patience_ns();
    if (!news_.empty()) tell(std::exchange(news_, {}));
    if (result != -EAGAIN && result != 0) return fault_of(result);
    // A poll() that only ever reports an error, and a driver that says "later": it will not recover on its own.
    if (!came && fds[0].revents & (POLLERR | POLLHUP | POLLNVAL)) return fault_of(-EIO);
    if (!came && system_.now_ns() >= deadline) return {FaultKind::hung, "no frame came for " + seconds(patience_ns())};
  }
  return {};
}

LiveCamera::Fault LiveCamera::fault_of(int result) const {
  if (result == -ENODEV || result == -ENXIO) return {FaultKind::unplugged, "it was unplugged (" + reason(result) + ")"};
  return {FaultKind::failed, "its driver failed (" + reason(result) + ")"};
}

int LiveCamera::take_in() {
  const std::lock_guard lock(mutex_);
  FilledBuffer buffer;
  if (const int result = session_->stream().dequeue(buffer); result < 0) return result;
  ++report_.dequeued;
  report_.damaged += buffer.damaged ? 1 : 0;
  report_.too_short += !buffer.damaged && is_too_short(buffer) ? 1 : 0;
  hold(buffer, judge(buffer));
  return 0;
}

bool LiveCamera::is_too_short(const FilledBuffer& buffer) const {
  return buffer.bytes.size() < session_->format().bytes_needed;
}

CameraFrame LiveCamera::judge(const FilledBuffer& buffer) {
  const std::int64_t now = system_.now_ns();
  CameraFrame frame{.sequence = buffer.sequence,
                    .t_sensor_ns = clock_.time_of(buffer.stamp, now),
                    .t_dequeue_ns = now,
                    .at_start = buffer.stamp.at_start,
                    .lost_before = sequence_.lost_before(buffer.sequence)};
  report_.lost += frame.lost_before;
  report_.replaced_stamps = clock_.replaced();
  report_.stamps_at_start = frame.at_start;
  if (std::exchange(first_of_session_, false) && std::exchange(after_outage_, false)) {
    const std::int64_t period = session_->format().period_ns();
    const std::int64_t away = frame.t_sensor_ns - last_sensor_ns_;
    const auto missed = static_cast<std::uint64_t>(period > 0 ? std::max<std::int64_t>(1, away / period - 1) : 1);
    frame.lost_before += missed;
    frame.after_outage = true;
    report_.outages.lost += missed;
    report_.outages.away_ns += now - t_fault_ns_;
    report_.outages.longest_return_ns = std::max(report_.outages.longest_return_ns, now - t_back_ns_);
    news_ = "streams again, after " + seconds(now - t_fault_ns_) + ": " + session_->format().text();
  }
  last_sensor_ns_ = frame.t_sensor_ns;
  return frame;
}

void LiveCamera::hold(const FilledBuffer& buffer, const CameraFrame& frame) {
  if (!options_.every_frame && !held_.empty()) {
    session_->stream().queue(held_.front().buffer.index);
    lost_unread_ += held_.front().frame.lost_before;
    outage_unread_ |= held_.front().frame.after_outage;
    ++report_.stale;
    held_.clear();
  }
  held_.push_back({buffer, frame});
  ready_ = true;
  changed_.notify_all();
  if (wake_) wake_();
}

// ---------------------------------------------------------------- away and back

void LiveCamera::close_session(const Fault& fault) {
  t_back_ns_ = system_.now_ns();
  if (!after_outage_) t_fault_ns_ = t_back_ns_;
  tell(fault.what + "; waiting for it");
  const std::lock_guard lock(mutex_);
  for (const Held& held : held_) {  // their bytes go with the session
    lost_unread_ += held.frame.lost_before;
    outage_unread_ |= held.frame.after_outage;
    ++report_.stale;
  }
  held_.clear();
  ready_ = false;
  session_.reset();
  report_.streaming = false;
  CameraReport::Outages& outages = report_.outages;
  ++(fault.kind == FaultKind::hung        ? outages.hung
     : fault.kind == FaultKind::unplugged ? outages.unplugged
                                          : outages.failed);
  after_outage_ = true;
}

void LiveCamera::recover(const Fault&) {
  constexpr std::int64_t kShortest_ns = 50 * kMillisecond_ns, kLongest_ns = 500 * kMillisecond_ns;
  const Descriptor watch(system_, system_.watch(folder_of(path_)));  // before the first look, so that nothing is missed
  std::int64_t pause = kShortest_ns;
  std::string told;
  while (!stop_.load()) {
    std::string problem;
    int code = 0;
    if (try_to_open(problem, code)) return;
    const bool absent = code == ENOENT;
    if (absent) t_back_ns_ = system_.now_ns();  // not before now, then
    if (!absent && problem != told) tell(told = problem);
    if (options_.give_up_ns > 0 && system_.now_ns() - t_fault_ns_ >= options_.give_up_ns)
      throw DeviceError(path_ + ": did not come back within " + seconds(options_.give_up_ns) + ": " + problem, code);
    std::array<pollfd, 2> fds{{{watch.get(), POLLIN, 0}, {wake_fd_.get(), POLLIN, 0}}};
    system_.poll(fds, absent ? kLongest_ns : pause);
    pause = std::min(2 * pause, kLongest_ns);
    eventfd_t word = 0;
    if (fds[1].revents) eventfd_read(wake_fd_.get(), &word);  // a word that is not taken wakes for ever
    if (!fds[0].revents) continue;
    system_.forget_events(watch.get());
    pause = kShortest_ns;
    if (absent) t_back_ns_ = system_.now_ns();
  }
}

void LiveCamera::tell(const std::string& what) const {
  if (tell_) tell_(what.starts_with(path_) ? what : path_ + ": " + what);
}

}  // namespace pavo::v4l2
