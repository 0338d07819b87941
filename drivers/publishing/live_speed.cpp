#include "drivers/publishing/live_speed.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

namespace pavo {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr double kFastest_m_per_s = 1e4;
constexpr std::size_t kLongestSample = 256, kMostFeeds = 16;

double seconds(std::int64_t from_ns, std::int64_t to_ns) {
  return static_cast<double>(to_ns - from_ns) * 1e-9;
}

}  // namespace

SpeedHistory::SpeedHistory(double hold_s) : hold_s_(hold_s), entries_(kMost) {}

bool SpeedHistory::add(const SpeedSample& sample) {
  const std::lock_guard lock(mutex_);
  Entry next{.sample = sample};
  if (count_ > 0) {
    const Entry& last = entry(count_ - 1);
    if (sample.t_ns <= last.sample.t_ns) return false;
    next.distance_m =
        last.distance_m + seconds(last.sample.t_ns, sample.t_ns) * 0.5 * (last.sample.m_per_s + sample.m_per_s);
  }
  if (count_ == kMost)
    first_ = (first_ + 1) % kMost;
  else
    ++count_;
  entries_[(first_ + count_ - 1) % kMost] = next;
  return true;
}

double SpeedHistory::distance_m(std::int64_t from_ns, std::int64_t to_ns) const {
  const std::lock_guard lock(mutex_);
  return std::abs(distance_until(to_ns) - distance_until(from_ns));
}

double SpeedHistory::distance_until(std::int64_t t_ns) const {
  if (count_ == 0) return kUnknown;
  const Entry &first = entry(0), &last = entry(count_ - 1);
  const auto held = [&](const Entry& e) {
    const double s = seconds(e.sample.t_ns, t_ns);
    return std::abs(s) > hold_s_ ? kUnknown : e.distance_m + s * e.sample.m_per_s;
  };
  if (t_ns <= first.sample.t_ns) return held(first);
  if (t_ns >= last.sample.t_ns) return held(last);
  std::size_t low = 0, high = count_ - 1;  // entry(low) <= t < entry(high)
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    (entry(middle).sample.t_ns <= t_ns ? low : high) = middle;
  }
  const Entry &a = entry(low), &b = entry(high);
  const double s = seconds(a.sample.t_ns, t_ns);
  const double acceleration = (b.sample.m_per_s - a.sample.m_per_s) / seconds(a.sample.t_ns, b.sample.t_ns);
  return a.distance_m + s * (a.sample.m_per_s + 0.5 * acceleration * s);
}

LiveSpeed::LiveSpeed(const std::string& where) {
  const std::string option = "--scale speed=" + where;
  if (where == "-")
    feeds_.push_back({.fd = STDIN_FILENO});
  else if (where.starts_with("unix:"))
    server_ = std::make_unique<UnixServer>(where.substr(5), option);
  else
    throw std::runtime_error(option + ": expected - (standard input) or unix:PATH");
  end_ = OwnedDescriptor(::eventfd(0, EFD_CLOEXEC));
  if (!end_) throw std::runtime_error(option + ": the system gives no eventfd");
  thread_ = std::jthread([this] { read_all(); });
}

LiveSpeed::~LiveSpeed() {
  const std::uint64_t one = 1;
  while (::write(end_.get(), &one, sizeof one) < 0 && errno == EINTR) {
  }
  thread_.join();
}

SpeedCounts LiveSpeed::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

void LiveSpeed::read_all() {
  std::vector<pollfd> waiting;
  for (;;) {
    waiting.assign({{end_.get(), POLLIN, 0}, {server_ ? server_->fd() : -1, POLLIN, 0}});
    for (const Feed& feed : feeds_) waiting.push_back({feed.fd, POLLIN, 0});
    if (::poll(waiting.data(), waiting.size(), -1) < 0) continue;  // EINTR
    if (waiting[0].revents) return;
    for (std::size_t i = feeds_.size(); i-- > 0;)
      if (waiting[i + 2].revents && !read_from(feeds_[i]))
        feeds_.erase(feeds_.begin() + static_cast<std::ptrdiff_t>(i));
    if (!waiting[1].revents) continue;
    while (OwnedDescriptor caller = server_->accept()) {
      if (feeds_.size() == kMostFeeds) continue;  // and hung up on
      const int fd = caller.get();
      feeds_.push_back({std::move(caller), fd, {}});
    }
  }
}

// poll() says that a read does not block now: one block, and back to it.
bool LiveSpeed::read_from(Feed& feed) {
  std::array<char, 4096> block{};
  const ssize_t got = ::read(feed.fd, block.data(), block.size());
  if (got < 0) return errno == EINTR || errno == EAGAIN;
  for (const char c : std::string_view(block.data(), static_cast<std::size_t>(got))) {
    if (c == '\n') {
      take(feed.line);
      feed.line.clear();
    } else if (feed.line.size() <= kLongestSample) {  // longer is no sample, and is not kept
      feed.line += c;
    }
  }
  if (got == 0 && !feed.line.empty()) take(feed.line);
  return got > 0;
}

void LiveSpeed::take(std::string_view line) {
  while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
  if (line.empty() || line.front() == '#') return;
  const std::optional<SpeedSample> sample = line.size() > kLongestSample ? std::nullopt : parse_speed_line(line);
  const bool taken = sample && std::abs(sample->m_per_s) < kFastest_m_per_s && history_.add(*sample);
  const std::lock_guard lock(mutex_);
  if (taken) {
    ++counts_.samples;
    return;
  }
  if (counts_.refused++ > 0) return;
  for (const char c : line.substr(0, 60)) counts_.first_refused += c >= ' ' && c <= '~' ? c : '?';
}

}  // namespace pavo
