// A device that holds its newest frame: read when there is room, and left in peace when the run is stopped.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <condition_variable>
#include <semaphore>

#include "tests/engine/numbers.h"

namespace pavo::test {
namespace {

using testing::ElementsAre;

class Device : public Source<Numbers> {
 public:
  bool holds_newest() const override { return true; }
  std::optional<std::int64_t> next_arrival_ns() override {
    ADD_FAILURE() << "a device does not know";
    return std::nullopt;
  }
  bool read(FrameInfo& info, Numbers& frame) override {
    std::unique_lock lock(mutex_);
    ++reads_;
    changed_.notify_all();
    changed_.wait(lock, [&] { return held_ || ended_; });
    if (!held_) return false;
    frame.input = info.source_index = *held_;
    info.stale = stale_;
    held_.reset();
    stale_ = 0;
    return true;
  }
  void interrupt() override {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }

  std::uint64_t unread() override {
    const std::lock_guard lock(mutex_);
    return stale_ + (held_ ? 1 : 0);
  }

  // --- the camera's side
  void take_picture(std::int64_t number) {
    const std::lock_guard lock(mutex_);
    stale_ += held_ ? 1 : 0;
    held_ = number;
    changed_.notify_all();
  }
  void wait_for_read(int count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return reads_ >= count; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<std::int64_t> held_;
  std::uint64_t stale_ = 0;
  bool ended_ = false;
  int reads_ = 0;
};

struct Gate {
  std::counting_semaphore<1000>& opened;
  void operator()(const std::int64_t& in, std::int64_t& out) const {
    opened.acquire();
    out = in;
  }
};

TEST(Device, IsReadWhenThereIsACreditAndWhatWentByIsStale) {
  SteadyClock clock;
  PipelineOptions options = workers(1);
  options.admission = Admission::live;
  options.live_credits = 1;
  Pipeline<Numbers> pipeline(options, clock);
  std::counting_semaphore<1000> opened{0};
  std::vector<Delivered> delivered;
  pipeline.source(writes(&Numbers::input));
  pipeline.add("gate", reads(&Numbers::input), writes(&Numbers::sum), Gate{opened}, parallel);
  pipeline.deliver(collect(delivered));
  pipeline.prepare();
  Device device;
  std::jthread runner([&] { pipeline.run(device); });
  device.wait_for_read(1);
  device.take_picture(0);
  while (pipeline.counts().in_flight == 0) std::this_thread::yield();
  for (std::int64_t k = 1; k <= 5; ++k) device.take_picture(k);  // no credit: nobody reads
  opened.release();
  device.wait_for_read(2);
  opened.release();
  device.wait_for_read(3);
  pipeline.stop();  // it waits for a picture that never comes
  runner.join();

  ASSERT_EQ(delivered.size(), 2u);
  EXPECT_EQ(delivered[1].source_index, 5);
  EXPECT_EQ(delivered[1].gap, 4u);
  const Counts counts = pipeline.counts();
  EXPECT_EQ(counts.in, 6u);
  EXPECT_EQ(counts.dropped_by[static_cast<std::size_t>(DropReason::stale)], 4u);
  EXPECT_EQ(counts.in, counts.done + counts.dropped);
}

TEST(Device, FramesThatNobodyReadAtTheEndAreInTheBooks) {
  SteadyClock clock;
  PipelineOptions options = workers(1);
  options.admission = Admission::live;
  options.live_credits = 1;
  Pipeline<Numbers> pipeline(options, clock);
  std::counting_semaphore<1000> opened{0};
  pipeline.source(writes(&Numbers::input));
  pipeline.add("gate", reads(&Numbers::input), writes(&Numbers::sum), Gate{opened}, parallel);
  pipeline.prepare();
  Device device;
  device.take_picture(0);
  std::jthread runner([&] { pipeline.run(device); });
  while (pipeline.counts().in_flight == 0) std::this_thread::yield();
  for (std::int64_t k = 1; k <= 3; ++k) device.take_picture(k);
  pipeline.stop();
  opened.release(10);
  runner.join();
  const Counts counts = pipeline.counts();
  EXPECT_EQ(counts.in, 4u);
  EXPECT_EQ(counts.dropped_by[static_cast<std::size_t>(DropReason::stopped)], 3u);
}

TEST(Device, ThatNeverDeliversIsStopped) {
  for (int i = 0; i < 20; ++i) {
    SteadyClock clock;
    PipelineOptions options = workers(2);
    options.admission = i % 2 == 0 ? Admission::live : Admission::every_frame;
    Pipeline<Numbers> pipeline(options, clock);
    pipeline.source(writes(&Numbers::input));
    pipeline.add("square", reads(&Numbers::input), writes(&Numbers::sum), Square{}, parallel);
    pipeline.prepare();
    Device device;
    std::jthread runner([&] { pipeline.run(device); });
    if (i >= 4) device.wait_for_read(1);
    pipeline.stop();
    runner.join();
    EXPECT_EQ(pipeline.counts().in, 0u);
  }
}

TEST(Device, IsInterruptedWhenTheDeliveryEndsTheRun) {
  SteadyClock clock;
  PipelineOptions options = workers(2);
  options.admission = Admission::live;
  Pipeline<Numbers> pipeline(options, clock);
  pipeline.source(writes(&Numbers::input));
  pipeline.add("square", reads(&Numbers::input), writes(&Numbers::sum), Square{}, parallel);
  pipeline.deliver([](const Numbers&, const FrameInfo&, const Outcome&) { throw std::runtime_error("disk full"); });
  pipeline.prepare();
  Device device;
  device.take_picture(0);
  EXPECT_THROW(pipeline.run(device), std::runtime_error);
}

}  // namespace
}  // namespace pavo::test
