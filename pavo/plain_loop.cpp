#include "pavo/plain_loop.h"

#include <cstring>
#include <ctime>
#include <utility>

#include "pavo/keyframe_stages.h"

namespace pavo {
namespace {

double thread_cpu_ms() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

void copy(const Image& from, Image& to) {
  to.resize(from.width(), from.height());
  for (int y = 0; y < from.height(); ++y) std::memcpy(to.row(y), from.row(y), static_cast<std::size_t>(from.width()));
}

}  // namespace

PlainLoop::PlainLoop(const Camera& rectified, const PlainLoopOptions& options,
                     std::shared_ptr<const StepLength> step_length)
    : options_(options),
      extract_(options.features, rectified.width, rectified.height),
      odometry_(rectified, options.odometry, std::move(step_length)),
      map_(rectified, options.map) {
  static_assert(kDelay == kMapDelay);
}

const MapUpdate* PlainLoop::update_to_read() const {
  if (!options_.with_map || frames_ < kDelay) return nullptr;
  return &updates_[(frames_ - kDelay) % updates_.size()];
}

void PlainLoop::run_map(const Image& image, const People& people) {
  MapUpdate& update = updates_[frames_ % updates_.size()];
  update.clear();
  const double start = thread_cpu_ms();
  if (record_.is_keyframe || (record_.followed && map_.needs_image())) map_(record_, image, people, update);
  map_ms_ = thread_cpu_ms() - start;
}

const PoseResult& PlainLoop::operator()(const FrameTime& now, const Image& image, const People& people) {
  const Slot& before = slots_[current_];
  current_ = 1 - current_;
  Slot& slot = slots_[current_];
  copy(image, slot.image);
  extract_(slot.image, slot.features, scratch_);
  const FrameView previous = before.there ? FrameView{&before.features, &before.image} : FrameView{};
  const double start = thread_cpu_ms();
  odometry_(now, {&slot.features, &slot.image}, previous, people, update_to_read(), pose_, record_);
  odometry_ms_ = thread_cpu_ms() - start;
  slot.there = true;
  run_map(slot.image, people);
  ++frames_;
  return pose_;
}

const PoseResult& PlainLoop::missed(const FrameTime& now) {
  const Slot& before = slots_[current_];
  const FrameView previous = before.there ? FrameView{&before.features, &before.image} : FrameView{};
  odometry_.missed(now, previous, update_to_read(), pose_, record_);
  current_ = 1 - current_;
  slots_[current_].there = false;
  updates_[frames_ % updates_.size()].clear();
  ++frames_;
  return pose_;
}

}  // namespace pavo
