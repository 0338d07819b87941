#include "tests/v4l2/played_driver.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

namespace pavo::v4l2::test {

// ---------------------------------------------------------------- the world outside

bool PlayedDriver::show(const Shown& shown) {
  const std::lock_guard lock(mutex_);
  if (!streaming_ || queued_.empty()) return false;
  const std::uint32_t index = queued_.front();
  queued_.pop_front();
  std::vector<std::uint8_t>& memory = memory_[index];
  std::fill(memory.begin(), memory.end(), shown.gray);
  std::copy_n(shown.picture.begin(), std::min(shown.picture.size(), memory.size()), memory.begin());
  filled_.emplace_back(index, shown);
  return true;
}

void PlayedDriver::unplug() {
  const std::lock_guard lock(mutex_);
  present = false;
  gone_ = true;
}

void PlayedDriver::plug_in() {
  const std::lock_guard lock(mutex_);
  present = true;
  events_ = true;
}

void PlayedDriver::advance(std::int64_t ns) {
  const std::lock_guard lock(mutex_);
  now_ns_ += ns;
}

std::int64_t PlayedDriver::now_ns() {
  const std::lock_guard lock(mutex_);
  return now_ns_;
}

// ---------------------------------------------------------------- descriptors and memory

int PlayedDriver::open(const std::string&) {
  const std::lock_guard lock(mutex_);
  if (open_fails < 0) return open_fails;
  if (!present) {
    ++found_none_;
    return -ENOENT;
  }
  EXPECT_TRUE(std::none_of(descriptors_.begin(), descriptors_.end(), [](auto& d) { return d.second == Kind::camera; }))
      << "opened twice";
  ++opened_;
  gone_ = false;
  descriptors_[next_fd_] = Kind::camera;
  return next_fd_++;
}

void PlayedDriver::close(int fd) {
  const std::lock_guard lock(mutex_);
  const auto found = descriptors_.find(fd);
  ASSERT_NE(found, descriptors_.end()) << "closed, and not open";
  if (found->second == Kind::camera) {
    stop();
    memory_.clear();
  }
  descriptors_.erase(found);
}

int PlayedDriver::watch(const std::string& directory) {
  const std::lock_guard lock(mutex_);
  EXPECT_EQ(directory, "/dev");
  descriptors_[next_fd_] = Kind::watch;
  return next_fd_++;
}

void PlayedDriver::forget_events(int) {
  const std::lock_guard lock(mutex_);
  events_ = false;
}

void* PlayedDriver::map(int, std::size_t bytes, std::int64_t offset) {
  const std::lock_guard lock(mutex_);
  auto& memory = memory_.at(static_cast<std::size_t>(offset));
  EXPECT_EQ(memory.size(), bytes);
  maps_[memory.data()] = bytes;
  return memory.data();
}

void PlayedDriver::unmap(void* start, std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  const auto found = maps_.find(start);
  ASSERT_NE(found, maps_.end()) << "unmapped, and not mapped";
  EXPECT_EQ(found->second, bytes);
  maps_.erase(found);
}

// The time of the test runs in advance() only; what is real (an eventfd) is asked for real.
int PlayedDriver::poll(std::span<pollfd> fds, std::int64_t timeout_ns) {
  const std::int64_t deadline = now_ns() + timeout_ns;
  for (;;) {
    int ready = 0;
    {
      const std::lock_guard lock(mutex_);
      for (pollfd& fd : fds) {
        fd.revents = 0;
        const auto known = descriptors_.find(fd.fd);
        if (known == descriptors_.end()) continue;
        if (known->second == Kind::watch && events_) fd.revents = POLLIN;
        if (known->second == Kind::camera && gone_) fd.revents = POLLERR | POLLHUP;
        if (known->second == Kind::camera && !filled_.empty()) fd.revents |= POLLIN;
        if (known->second == Kind::camera && !fails[VIDIOC_DQBUF].empty()) fd.revents |= POLLERR;
        ready += fd.revents != 0;
      }
    }
    for (pollfd& fd : fds) {
      pollfd real = fd;
      if (fd.fd < 0 || fd.fd >= 100000 || ::poll(&real, 1, 0) <= 0) continue;
      fd.revents = real.revents;
      ++ready;
    }
    if (ready > 0) return ready;
    if (timeout_ns >= 0 && now_ns() >= deadline) return 0;
    if (fds.empty()) advance(timeout_ns);  // a pause: nobody else moves the clock
    std::this_thread::sleep_for(std::chrono::microseconds(50));
  }
}

// ---------------------------------------------------------------- the driver

int PlayedDriver::ioctl(int fd, unsigned long request, void* argument) {
  const std::lock_guard lock(mutex_);
  EXPECT_TRUE(descriptors_.contains(fd)) << "an ioctl on what is closed";
  if (auto& errors = fails[request]; !errors.empty()) {
    const int error = errors.front();
    errors.pop_front();
    return error;
  }
  if (gone_) return -ENODEV;
  return answer(request, argument);
}

int PlayedDriver::answer(unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto& c = *static_cast<v4l2_capability*>(argument);
      std::memcpy(c.card, card.data(), std::min(card.size(), sizeof c.card));
      std::memcpy(c.driver, "played", 6);
      c.capabilities = V4L2_CAP_DEVICE_CAPS | V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
      c.device_caps = device_caps;
      return 0;
    }
    case VIDIOC_ENUM_FMT:
    case VIDIOC_ENUM_FRAMESIZES:
    case VIDIOC_ENUM_FRAMEINTERVALS:
      return enumerate(request, argument);
    case VIDIOC_G_FMT:
      static_cast<v4l2_format*>(argument)->fmt.pix = format_;
      return 0;
    case VIDIOC_S_FMT:
      return set_format(*static_cast<v4l2_format*>(argument));
    case VIDIOC_G_PARM:
    case VIDIOC_S_PARM: {
      auto& capture = static_cast<v4l2_streamparm*>(argument)->parm.capture;
      if (request == VIDIOC_S_PARM) {
        const double asked = static_cast<double>(capture.timeperframe.denominator) / capture.timeperframe.numerator;
        rate_hz_ = std::min(asked, offer(format_.pixelformat)->fastest_hz);
      }
      capture.capability = V4L2_CAP_TIMEPERFRAME;
      capture.timeperframe = {1000, static_cast<std::uint32_t>(rate_hz_ * 1000)};
      return 0;
    }
    case VIDIOC_REQBUFS:
      return request_buffers(*static_cast<v4l2_requestbuffers*>(argument));
    case VIDIOC_QUERYBUF: {
      auto& buffer = *static_cast<v4l2_buffer*>(argument);
      if (buffer.index >= memory_.size()) return -EINVAL;
      buffer.length = static_cast<std::uint32_t>(memory_[buffer.index].size());
      buffer.m.offset = buffer.index;
      return 0;
    }
    case VIDIOC_QBUF:
      return queue(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_DQBUF:
      return dequeue(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON:
      EXPECT_FALSE(memory_.empty());
      streaming_ = true;
      return 0;
    case VIDIOC_STREAMOFF:
      stop();
      return 0;
    default:
      return -ENOTTY;
  }
}

const PlayedDriver::Offer* PlayedDriver::offer(std::uint32_t fourcc) const {
  const auto found = std::find_if(offers.begin(), offers.end(), [&](const Offer& o) { return o.fourcc == fourcc; });
  return found == offers.end() ? nullptr : &*found;
}

int PlayedDriver::enumerate(unsigned long request, void* argument) const {
  if (request == VIDIOC_ENUM_FMT) {
    auto& d = *static_cast<v4l2_fmtdesc*>(argument);
    if (d.index >= offers.size()) return -EINVAL;
    d.pixelformat = offers[d.index].fourcc;
    return 0;
  }
  if (request == VIDIOC_ENUM_FRAMESIZES) {
    auto& e = *static_cast<v4l2_frmsizeenum*>(argument);
    const Offer* o = offer(e.pixel_format);
    if (!o || e.index >= o->sizes.size()) return -EINVAL;
    e.type = V4L2_FRMSIZE_TYPE_DISCRETE;
    e.discrete = {static_cast<std::uint32_t>(o->sizes[e.index].first),
                  static_cast<std::uint32_t>(o->sizes[e.index].second)};
    return 0;
  }
  auto& e = *static_cast<v4l2_frmivalenum*>(argument);
  const Offer* o = offer(e.pixel_format);
  if (!o || e.index > 0) return -EINVAL;
  e.type = V4L2_FRMIVAL_TYPE_DISCRETE;
  e.discrete = {1000, static_cast<std::uint32_t>(o->fastest_hz * 1000)};
  return 0;
}

int PlayedDriver::set_format(v4l2_format& format) {
  EXPECT_TRUE(memory_.empty()) << "a format while there are buffers";
  v4l2_pix_format& pix = format.fmt.pix;
  if (!offer(pix.pixelformat)) pix.pixelformat = offers.front().fourcc;
  const std::uint32_t row = pix.pixelformat == V4L2_PIX_FMT_YUYV ? 2 * pix.width : pix.width;
  pix.bytesperline = pix.pixelformat == V4L2_PIX_FMT_MJPEG ? 0 : row + padding;
  pix.sizeimage = (row + padding) * pix.height;
  pix.field = V4L2_FIELD_NONE;
  if (changes) changes(pix);
  format_ = pix;
  return 0;
}

int PlayedDriver::request_buffers(v4l2_requestbuffers& request) {
  if (request.count == 0) {
    EXPECT_TRUE(maps_.empty()) << "given back while they are mapped";
    stop();
  } else {
    EXPECT_TRUE(memory_.empty()) << "asked for twice";
  }
  request.count = std::min(request.count, most_buffers);
  memory_.assign(request.count, std::vector<std::uint8_t>(format_.sizeimage));
  return 0;
}

int PlayedDriver::queue(const v4l2_buffer& buffer) {
  EXPECT_LT(buffer.index, memory_.size());
  EXPECT_EQ(std::count(queued_.begin(), queued_.end(), buffer.index), 0) << "queued twice";
  EXPECT_TRUE(std::none_of(filled_.begin(), filled_.end(), [&](auto& f) { return f.first == buffer.index; }));
  queued_.push_back(buffer.index);
  return 0;
}

int PlayedDriver::dequeue(v4l2_buffer& buffer) {
  if (filled_.empty()) return -EAGAIN;
  const auto [index, shown] = filled_.front();
  filled_.pop_front();
  buffer.index = index;
  buffer.sequence = shown.sequence;
  buffer.flags = shown.flags;
  buffer.bytesused = std::min<std::uint32_t>(shown.bytes_used, format_.sizeimage);
  buffer.timestamp.tv_sec = shown.stamp_ns / 1'000'000'000;
  buffer.timestamp.tv_usec = shown.stamp_ns % 1'000'000'000 / 1000;
  return 0;
}

void PlayedDriver::stop() {
  streaming_ = false;
  queued_.clear();
  filled_.clear();
}

}  // namespace pavo::v4l2::test
