// A camera on the driver that the test plays.
#pragma once

#include <gmock/gmock.h>

#include <chrono>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "drivers/v4l2/live_camera.h"
#include "tests/v4l2/played_driver.h"

namespace pavo::v4l2::test {

constexpr std::int64_t kMs = 1'000'000;

inline CameraOptions asking(bool every_frame = true, int buffers = 4) {
  CameraOptions options;
  options.format.size = {64, 32};
  options.buffers = buffers;
  options.every_frame = every_frame;
  return options;
}

/// Real time passes only for the other thread to get on.
template <class Condition>
bool eventually(Condition&& condition) {
  for (int n = 0; n < 200'000; ++n) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  return false;
}

struct Played {
  explicit Played(const CameraOptions& how = asking()) : options(how) {}
  void open() {
    camera.emplace(driver, "/dev/video0", options, [this](const std::string& event) {
      const std::lock_guard lock(mutex);
      events += event + "\n";
    });
  }
  bool told(const std::string& what) {
    const std::lock_guard lock(mutex);
    return events.find(what) != std::string::npos;
  }
  /// Shows a frame that is taken 20 ms ago, as far as the driver says.
  void show(std::uint32_t sequence, std::uint32_t flags = Shown().flags) {
    Shown shown;
    shown.sequence = sequence;
    shown.stamp_ns = driver.now_ns() - 20 * kMs;
    shown.flags = flags;
    show(shown);
  }
  void show(const Shown& shown) {
    ASSERT_TRUE(eventually([&] { return driver.show(shown); })) << "no buffer is queued";
  }
  void take() {
    ASSERT_TRUE(eventually([&] { return camera->ready(); })) << "no frame came";
    ASSERT_TRUE(camera->wait());
    ASSERT_TRUE(camera->take(image, frame));
  }
  void show_and_take(std::uint32_t sequence) {
    driver.advance(33 * kMs);
    show(sequence);
    take();
  }
  /// Shows and takes, again and again, until the camera is back.
  void come_back(std::uint32_t sequence = 0) {
    ASSERT_TRUE(eventually([&] {
      driver.advance(100 * kMs);
      return driver.streams() && camera->report().streaming;
    }));
    show_and_take(sequence);
  }

  PlayedDriver driver;
  CameraOptions options;
  std::mutex mutex;
  std::string events;
  EncodedImage image;
  CameraFrame frame;
  std::optional<LiveCamera> camera;
};

/// The message of the DeviceError that opening gives; "" where it opens.
inline std::string refusal(Played& played) {
  try {
    played.open();
  } catch (const DeviceError& e) {
    return e.what();
  }
  return "";
}

}  // namespace pavo::v4l2::test
