// pavo's own stages, as `pavo run` has them by default.
#include <array>
#include <atomic>
#include <bit>
#include <deque>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <stdexcept>

#include "bench/pipeline/work.h"
#include "drivers/models/model_file.h"
#include "stages/decode/decode.h"
#include "stages/features/extract.h"
#include "stages/people/scan.h"
#include "stages/people/track_people.h"
#include "stages/pose/odometry.h"
#include "tools/pavo/bench_frames.h"

namespace pavo::bench {
namespace {

// Scratch memory for whoever comes, the warmest first.
template <class T>
class Pool {
 public:
  Pool() : items_(32) {}
  class Lease {
   public:
    explicit Lease(Pool& pool) : pool_(pool), index_(pool.take()) {}
    ~Lease() { pool_.free_.fetch_or(std::uint32_t{1} << index_); }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    T& operator*() { return pool_.items_[static_cast<std::size_t>(index_)]; }

   private:
    Pool& pool_;
    int index_;
  };

 private:
  int take() {
    std::uint32_t free = free_.load();
    while (!free_.compare_exchange_weak(free, free & (free - 1))) {
    }
    return std::countr_zero(free);
  }
  std::deque<T> items_;
  std::atomic<std::uint32_t> free_{~std::uint32_t{0}};
};

class Real final : public Work {
 public:
  Real(Sequence& sequence, int frames) : frames_(sequence, frames) {
    cv::setNumThreads(1);
    const SequenceInfo& info = sequence.info();
    if (!info.camera || info.camera->lens != Lens::rectified)
      throw std::runtime_error(info.path + ": expected a source of rectified frames with their calibration");
    camera_ = *info.camera;
    decode_.emplace(camera_.width, camera_.height);
    FeatureOptions options;
    options.max_features = 2000;
    features_.emplace(options, camera_.width, camera_.height, ImageView{});
  }

  void begin(int tokens, Spread* spread) override {
    places_ = std::deque<Place>(static_cast<std::size_t>(tokens) + 1);
    scan_.emplace(default_pedestrian_model(), ScanHogOptions{.threshold = 0.1f, .spread = spread});
    people_.emplace();
    OdometryOptions options;
    options.match_ratio = 0.85f;
    options.spread = spread;
    odometry_.emplace(camera_, options, std::make_shared<UnitStep>());
    result_ = 14695981039346656037u;
  }

  void load(std::int64_t k) override {
    const EncodedImage& from = frames_.at(k);
    EncodedImage& to = at(k).encoded;
    to.encoding = from.encoding;
    to.width = from.width;
    to.height = from.height;
    to.stride = from.stride;
    to.bytes.assign(from.bytes.begin(), from.bytes.end());
  }

  void stage(int stage, std::int64_t k) override {
    Place& place = at(k);
    switch (stage) {
      case 0:
        (*decode_)(place.encoded, place.image, *Pool<Decode::Scratch>::Lease(decode_scratch_));
        break;
      case 1:
        (*features_)(place.image, place.features, *Pool<ExtractFeatures::Scratch>::Lease(features_scratch_));
        break;
      case 2:
        (*scan_)(place.image, place.detections, *Pool<ScanPeople::Scratch>::Lease(scan_scratch_));
        break;
      case 3:
        (*people_)(place.detections, place.people);
        break;
      default:
        estimate(place, k);
    }
  }

  std::uint64_t result() const override { return result_; }

 private:
  struct Place {
    EncodedImage encoded;
    Image image;
    Features features;
    Detections detections;
    People people;
    PoseResult pose;
  };
  Place& at(std::int64_t k) { return places_[static_cast<std::size_t>(k) % places_.size()]; }

  void estimate(Place& place, std::int64_t k) {
    const FrameTime time{.index = k, .t_ns = k * 100'000'000};
    const FrameView previous = k > 0 ? FrameView{&at(k - 1).features, &at(k - 1).image} : FrameView{};
    (*odometry_)(time, {&place.features, &place.image}, previous, place.people, place.pose);
    for (int i = 0; i < 9; ++i) mix(place.pose.T_w_c.R(i / 3, i % 3));
    for (int i = 0; i < 3; ++i) mix(place.pose.T_w_c.t(i));
  }
  void mix(double number) { result_ = (result_ ^ std::bit_cast<std::uint64_t>(number)) * 1099511628211u; }

  BenchFrames frames_;
  Camera camera_;
  std::optional<Decode> decode_;
  std::optional<ExtractFeatures> features_;
  std::optional<ScanPeople> scan_;
  std::optional<TrackPeople> people_;
  std::optional<Odometry> odometry_;
  Pool<Decode::Scratch> decode_scratch_;
  Pool<ExtractFeatures::Scratch> features_scratch_;
  Pool<ScanPeople::Scratch> scan_scratch_;
  std::deque<Place> places_;
  std::uint64_t result_ = 0;
};

}  // namespace

std::unique_ptr<Work> real_work(Sequence& sequence, int frames) {
  return std::make_unique<Real>(sequence, frames);
}

}  // namespace pavo::bench
