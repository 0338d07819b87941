// Ours: the engine, with all its metrics.
#include "bench/pipeline/competitors.h"
#include "engine/pipeline.h"
#include "pavo/workers_spread.h"

namespace pavo::bench {
namespace {

// A part stands for what the work keeps in the frame's place.
struct Slot {
  struct Done {
    std::int64_t k = 0;
  };
  struct Loaded : Done {};
  struct Image : Done {};
  struct Features : Done {};
  struct Detections : Done {};
  struct People : Done {};
  struct Pose : Done {};
  Loaded loaded;
  Image image;
  Features features;
  Detections detections;
  People people;
  Pose pose;
};

// In-order stages say what they do for a frame that failed; none does here.
struct People {
  Work& work;
  void operator()(const Slot::Detections& detections, Slot::People& people) {
    work.stage(3, detections.k);
    people.k = detections.k;
  }
  void missed(Slot::People&) {}
};

struct Odometry {
  Work& work;
  void operator()(const Slot::Features& now, const Slot::People&, const Slot::Features*, Slot::Pose& pose) {
    work.stage(4, now.k);
    pose.k = now.k;
  }
  void missed(const Slot::Features*, Slot::Pose&) {}
};

class FeedSource final : public Source<Slot> {
 public:
  FeedSource(Work& work, Feed& feed) : work_(work), feed_(feed) {}
  bool read(FrameInfo& info, Slot& slot) override {
    const std::int64_t k = feed_.next();
    if (k < 0) return false;
    work_.load(k);
    slot.loaded.k = k;
    info.source_index = k;
    info.t_arrival_ns = feed_.arrival_ns(k);
    return true;
  }
  std::optional<std::int64_t> next_arrival_ns() override { return std::nullopt; }

 private:
  Work& work_;
  Feed& feed_;
};

}  // namespace

void run_pavo(Work& work, Feed& feed, const Setup& setup) {
  SteadyClock clock;
  Pipeline<Slot> p({.workers = setup.threads, .slots = setup.tokens + 1}, clock);
  WorkersSpread<Slot> spread(p, setup.threads);
  work.begin(setup.tokens, &spread);
  const auto stage = [&work](int s) {
    return [&work, s](const auto& in, auto& out) {
      work.stage(s, in.k);
      out.k = in.k;
    };
  };
  p.source(writes(&Slot::loaded));
  p.add("decode", reads(&Slot::loaded), writes(&Slot::image), stage(0), parallel);
  p.add("features", reads(&Slot::image), writes(&Slot::features), stage(1), parallel);
  p.add("scan", reads(&Slot::image), writes(&Slot::detections), stage(2), parallel);
  p.add("people", reads(&Slot::detections), writes(&Slot::people), People{work}, in_order);
  p.add("odometry", reads(&Slot::features, &Slot::people, previous(&Slot::features)), writes(&Slot::pose),
        Odometry{work}, in_order);
  p.deliver([&feed](const Slot& slot, const FrameInfo&, const Outcome&) { feed.done(slot.pose.k); });
  FeedSource source(work, feed);
  p.run(source);
}

}  // namespace pavo::bench
