#include "tools/pavo/bench_frames.h"

#include <cmath>
#include <stdexcept>

namespace pavo {
namespace {

constexpr std::int64_t kOneSecond_ns = 1'000'000'000;
constexpr double kUnpacedRate_hz = 10;  // of the frames' times, where nobody waits for them

}  // namespace

BenchFrames::BenchFrames(Sequence& sequence, int count) {
  EncodedImage image;
  FrameStamp stamp;
  while (static_cast<int>(frames_.size()) < count && sequence.read(image, stamp)) frames_.push_back(image);
  if (frames_.empty()) throw std::runtime_error(sequence.info().path + ": not one frame came from it");
}

const EncodedImage& BenchFrames::at(std::int64_t k) const {
  const auto n = static_cast<std::int64_t>(frames_.size());
  if (n == 1) return frames_[0];
  const std::int64_t within = k % (2 * n - 2);
  return frames_[static_cast<std::size_t>(within < n ? within : 2 * n - 2 - within)];
}

PacedSource::PacedSource(const BenchFrames& frames, const Pace& pace, Clock& clock)
    : frames_(frames), pace_(pace), clock_(clock) {}

void PacedSource::begin() {
  if (start_ns_ == 0) start_ns_ = clock_.now_ns();
}

std::int64_t PacedSource::arrival_ns(std::int64_t k) const {
  return start_ns_ + std::llround(static_cast<double>(k) / pace_.rate_hz * kOneSecond_ns);
}

std::optional<std::int64_t> PacedSource::next_arrival_ns() {
  begin();
  if (next_ == pace_.frames) return std::nullopt;
  return pace_.rate_hz > 0 ? arrival_ns(next_) : clock_.now_ns();
}

bool PacedSource::read(FrameInfo& info, Frame& frame) {
  begin();
  const bool time_is_up = pace_.until_ns > 0 && clock_.now_ns() - start_ns_ >= pace_.until_ns;
  if (next_ == pace_.frames || (time_is_up && next_ >= pace_.at_least)) return false;
  if (pace_.rate_hz > 0) {
    info.t_arrival_ns = arrival_ns(next_);
    while (!pace_.live && clock_.now_ns() < info.t_arrival_ns)
      clock_.wait(nobody_notifies_, nobody_notifies_.prepare(), info.t_arrival_ns);
  }
  const EncodedImage& image = frames_.at(next_);
  frame.encoded.encoding = image.encoding;
  frame.encoded.width = image.width;
  frame.encoded.height = image.height;
  frame.encoded.stride = image.stride;
  frame.encoded.bytes.assign(image.bytes.begin(), image.bytes.end());
  info.source_index = next_;
  const double rate_hz = pace_.rate_hz > 0 ? pace_.rate_hz : kUnpacedRate_hz;
  info.t_capture_ns = std::llround(static_cast<double>(next_) / rate_hz * kOneSecond_ns);
  ++next_;
  return true;
}

}  // namespace pavo
