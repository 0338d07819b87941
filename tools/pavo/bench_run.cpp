#include "tools/pavo/bench_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <stdexcept>

#include "pavo/odometry_pipeline.h"

namespace pavo {
namespace {

constexpr double kNsPerSecond = 1e9;

struct Delivered {
  std::int64_t index = 0, t_ns = 0, end_to_end_ns = 0, age_ns = 0;
};

Quantiles exact_quantiles_ms(std::vector<std::int64_t> ns) {
  if (ns.empty()) return {};
  std::sort(ns.begin(), ns.end());
  const auto at = [&](double q) {
    const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(ns.size())));
    return static_cast<double>(ns[std::max<std::size_t>(rank, 1) - 1]) * 1e-6;
  };
  return {at(0.5), at(0.9), at(0.99), at(0.999), static_cast<double>(ns.back()) * 1e-6, ns.size()};
}

// The first frames touch new memory and cold caches, and the first queue is not what it will be.
struct Plan {
  std::int64_t warm_up_frames = 0;
  PacedSource::Pace pace;
};

Plan plan_of(const BenchLoad& load, bool live) {
  constexpr double kWarmUpShare = 0.25, kLongestWarmUp_s = 1;
  constexpr std::int64_t kLeastFrames = 12;  // every slot of the ring once
  const double warm_up_s = std::min(kLongestWarmUp_s, load.seconds * kWarmUpShare);
  Plan plan{.warm_up_frames = kLeastFrames, .pace = {.rate_hz = load.rate_hz, .live = live}};
  if (load.rate_hz > 0) {
    plan.warm_up_frames = std::max<std::int64_t>(kLeastFrames, std::llround(warm_up_s * load.rate_hz));
    plan.pace.frames = plan.warm_up_frames + std::max<std::int64_t>(2, std::llround(load.seconds * load.rate_hz));
  } else {
    plan.pace.frames = -1;
    plan.pace.until_ns = std::llround((warm_up_s + load.seconds) * kNsPerSecond);
    plan.pace.at_least = plan.warm_up_frames + 2;
  }
  return plan;
}

// The run's pipeline, and what is written down of every frame that comes out of it.
class Measurement {
 public:
  Measurement(const Config& config, const Camera& camera, const BenchFrames& frames, const Plan& plan)
      : plan_(plan),
        pipeline_(config, camera, std::make_shared<UnitStep>(), Input::encoded, clock_),
        source_(frames, plan.pace, clock_) {
    constexpr std::int64_t kReserved = 1 << 20;
    delivered_.reserve(static_cast<std::size_t>(plan.pace.frames > 0 ? plan.pace.frames : kReserved));
    pipeline_.engine().deliver([this](const Frame&, const FrameInfo& info, const Outcome& outcome) {
      if (outcome.failed)
        throw std::runtime_error("a frame failed, and figures without it would mean nothing; " +
                                 std::string(outcome.stage) + ": " + std::string(outcome.message));
      const std::int64_t now = clock_.now_ns();
      if (info.source_index < plan_.warm_up_frames) {
        pipeline_.engine().forget_latencies();
        warm_ns_ = now;
        return;
      }
      const std::int64_t sensor = info.t_sensor_ns != 0 ? info.t_sensor_ns : info.t_arrival_ns;
      delivered_.push_back({info.source_index, now, now - info.t_arrival_ns, now - sensor});
    });
  }

  void trace_to(Trace& trace) { pipeline_.engine().trace_to(trace); }

  BenchRun run() {
    pipeline_.engine().run(source_);
    if (delivered_.empty()) throw std::runtime_error("no frame came out behind the warm-up: give it more --seconds");
    BenchRun result;
    result.done = static_cast<std::int64_t>(delivered_.size());
    // From the last frame of the warm-up to the last of all: as many intervals as frames.
    double seconds = static_cast<double>(delivered_.back().t_ns - warm_ns_) / kNsPerSecond;
    if (plan_.pace.rate_hz > 0)  // a late end of the warm-up does not make it more than was offered
      seconds = std::max(seconds, static_cast<double>(plan_.pace.frames - plan_.warm_up_frames) / plan_.pace.rate_hz);
    result.done_fps = static_cast<double>(result.done) / std::max(seconds, 1e-9);
    result.offered_fps = plan_.pace.rate_hz > 0 ? plan_.pace.rate_hz : result.done_fps;
    if (plan_.pace.rate_hz > 0) result.dropped = plan_.pace.frames - plan_.warm_up_frames - result.done;
    result.end_to_end_ms = quantiles_of(&Delivered::end_to_end_ns);
    result.age_ms = quantiles_of(&Delivered::age_ns);
    result.stages = stages();
    return result;
  }

  void append_samples(std::vector<BenchSample>& samples) const {
    const std::int64_t start = delivered_.front().t_ns - delivered_.front().age_ns;
    for (const Delivered& d : delivered_)
      samples.push_back({static_cast<double>(d.t_ns - start) / kNsPerSecond, static_cast<double>(d.age_ns) * 1e-6});
  }

 private:
  Quantiles quantiles_of(std::int64_t Delivered::*member) const {
    std::vector<std::int64_t> values;
    for (const Delivered& d : delivered_) values.push_back(d.*member);
    return exact_quantiles_ms(std::move(values));
  }

  std::vector<StageFigures> stages() {
    std::vector<StageFigures> all;
    const Runtime& runtime = pipeline_.engine().runtime();
    for (std::size_t n = 1; n < runtime.graph().delivery(); ++n) {
      const StageMetrics& m = runtime.stage_metrics(n);
      all.push_back(
          {runtime.graph().nodes[n].name, m.wait.quantiles_ms(), m.service.quantiles_ms(), m.cpu.quantiles_ms()});
    }
    return all;
  }

  Plan plan_;
  SteadyClock clock_;
  OdometryPipeline pipeline_;
  PacedSource source_;
  std::vector<Delivered> delivered_;  // by the delivery, in order
  std::int64_t warm_ns_ = 0;
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

template <class Get>
double median_by(const std::vector<BenchRun>& runs, const Get& get) {
  std::vector<double> values;
  for (const BenchRun& run : runs) values.push_back(get(run));
  return median(std::move(values));
}

// `get` gives the quantiles of one run.
template <class Get>
Quantiles median_quantiles(const std::vector<BenchRun>& runs, const Get& get) {
  Quantiles result;
  for (double Quantiles::*q : {&Quantiles::p50, &Quantiles::p90, &Quantiles::p99, &Quantiles::p999, &Quantiles::max})
    result.*q = median_by(runs, [&](const BenchRun& run) { return get(run).*q; });
  for (const BenchRun& run : runs) result.count += get(run).count;
  return result;
}

}  // namespace

BenchRun bench_run(const Config& config, const Camera& camera, const BenchFrames& frames, const BenchLoad& load,
                   std::vector<BenchSample>& samples) {
  Config how = config;
  if (load.rate_hz <= 0) how.source.mode = "every-frame";
  Measurement measurement(how, camera, frames, plan_of(load, how.source.mode == "live"));
  if (load.trace) measurement.trace_to(*load.trace);
  const BenchRun run = measurement.run();
  measurement.append_samples(samples);
  return run;
}

BenchRun median_of(const std::vector<BenchRun>& runs) {
  BenchRun result = runs.front();
  result.offered_fps = median_by(runs, [](const BenchRun& r) { return r.offered_fps; });
  result.done_fps = median_by(runs, [](const BenchRun& r) { return r.done_fps; });
  result.done = std::llround(median_by(runs, [](const BenchRun& r) { return static_cast<double>(r.done); }));
  result.dropped = std::llround(median_by(runs, [](const BenchRun& r) { return static_cast<double>(r.dropped); }));
  result.end_to_end_ms = median_quantiles(runs, [](const BenchRun& r) { return r.end_to_end_ms; });
  result.age_ms = median_quantiles(runs, [](const BenchRun& r) { return r.age_ms; });
  for (std::size_t s = 0; s < result.stages.size(); ++s) {
    StageFigures& stage = result.stages[s];
    for (Quantiles StageFigures::*what : {&StageFigures::wait_ms, &StageFigures::service_ms, &StageFigures::cpu_ms})
      stage.*what = median_quantiles(runs, [&](const BenchRun& r) { return r.stages[s].*what; });
  }
  return result;
}

}  // namespace pavo
