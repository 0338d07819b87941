// Which buffer of a delayed value is written, which is read: the values themselves are Pipeline's.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

namespace pavo {

/// One writer (the background stage), any number of readers, each a thread at a time; nobody ever waits or allocates.
///
/// Exact (replay): the value of frame k lies in buffer k mod n. Whoever reads it comes behind its writer, and whoever
/// overwrites it behind its readers: the graph sees to that, and nothing here.
/// Live: a reader pins the newest buffer, looks whether it still is the newest, and keeps it until let_go(); the writer
/// takes one that is neither pinned nor the newest. With readers + 2 buffers there always is one. (The pin and the
/// second look are a hazard pointer, Michael 2004.)
class DelayedValues {
 public:
  static constexpr int kNothing = -1;

  DelayedValues(int buffers, bool exact)
      : buffers_(std::make_unique<Buffer[]>(static_cast<std::size_t>(buffers))), count_(buffers), exact_(exact) {}

  // --- the writer
  int to_write(std::uint64_t sequence) const {
    if (exact_) return static_cast<int>(sequence % static_cast<std::uint64_t>(count_));
    for (int b = 0;; b = b + 1 == count_ ? 0 : b + 1)
      if (b != newest_.load() && buffers_[b].pins.load() == 0) return b;
  }
  void publish(int buffer, std::uint64_t sequence) {
    buffers_[buffer].stamp.store(sequence + 1);
    newest_.store(buffer);
  }

  // --- a reader
  /// The buffer of what frame `sequence` shall read, or kNothing. Live, each value is given once: `last_seen` is the
  /// reader's own memory of it, 0 at first.
  int take(std::uint64_t sequence, int delay, std::uint64_t& last_seen) {
    const auto d = static_cast<std::uint64_t>(delay);
    if (!exact_) return pin_newest(last_seen);
    if (sequence < d) return kNothing;
    const int buffer = to_write(sequence - d);
    return buffers_[buffer].stamp.load() == sequence - d + 1 ? buffer : kNothing;
  }
  void let_go(int buffer) {
    if (!exact_ && buffer != kNothing) buffers_[buffer].pins.fetch_sub(1);
  }

 private:
  struct Buffer {
    std::atomic<std::uint64_t> stamp{0};  ///< the frame's sequence + 1
    std::atomic<int> pins{0};
  };

  int pin_newest(std::uint64_t& last_seen) {
    for (;;) {
      const int buffer = newest_.load();
      if (buffer == kNothing) return kNothing;
      buffers_[buffer].pins.fetch_add(1);
      if (newest_.load() == buffer) {
        const std::uint64_t stamp = buffers_[buffer].stamp.load();
        if (stamp != last_seen) {
          last_seen = stamp;
          return buffer;
        }
        let_go(buffer);
        return kNothing;
      }
      let_go(buffer);
    }
  }

  std::unique_ptr<Buffer[]> buffers_;
  int count_;
  bool exact_;
  std::atomic<int> newest_{kNothing};
};

}  // namespace pavo
